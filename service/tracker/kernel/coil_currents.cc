#include "service/tracker/kernel/coil_currents.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"

namespace omni::tracker {
namespace {

constexpr double kScanGapMax_s = 5e-3;  // means are not interpolated over a longer gap
constexpr std::uint64_t kTickGapMax = 20;
constexpr double kLeak_s = 1e-7;       // per tick: 100 ppm
constexpr double kCurrentMax_A = 1e3;  // a larger value is no current
constexpr double kSteps_Hz = base::kStepsPerTick / base::kTickPeriod_s;

bool HasSteps(const base::HallScan& scan) noexcept {
  return scan.has_steps != 0 && scan.tick_lead_ns >= 0 && scan.tick_lead_ns <= 2 * base::kTickPeriod_ns &&
         std::all_of(scan.step_current_A.begin(), scan.step_current_A.end(), &ArePlausible);
}

// dI/dt between two means; zero when the scan before is missing or too old.
Currents RateOfMeans(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  Currents rate_A_s{};
  const double dt_s = base::Elapsed_s(scan.t_ns, previous.t_ns);
  if (!previous.valid || !ArePlausible(previous.coil_current_A)) return rate_A_s;
  if (!(dt_s > 0 && dt_s <= kScanGapMax_s)) return rate_A_s;
  for (std::size_t k = 0; k < rate_A_s.size(); ++k) {
    rate_A_s[k] = (scan.coil_current_A[k] - previous.coil_current_A[k]) / dt_s;
  }
  return rate_A_s;
}

// t_ns = (tick end) - lead, and ticks end every millisecond: lead grows by what the stamp fell behind the tick count.
// Free-running sensors make lead touch zero every few hundred scans; there the tick's end is seen. The slow leak
// follows a drifting device clock.
double LearntLead_s(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  const double elapsed_s = base::Elapsed_s(scan.t_ns, previous.t_ns);
  const std::uint64_t ticks = scan.sequence - previous.sequence;
  if (!previous.valid || !(ticks >= 1 && ticks <= kTickGapMax)) return 0;
  const double lead_s =
      previous.stamp_lead_s + static_cast<double>(ticks) * (base::kTickPeriod_s - kLeak_s) - elapsed_s;
  return lead_s > 0 && lead_s < base::kTickPeriod_s ? lead_s : 0.0;
}

}  // namespace

bool ArePlausible(const Currents& current_A) noexcept {
  for (const double current : current_A) {
    if (!(std::abs(current) <= kCurrentMax_A)) return false;
  }
  return true;
}

// Before the first reported step, currents are assumed to have been what they were there.
CurrentHistory UpdatedHistory(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  CurrentHistory now;
  now.valid = true;
  now.t_ns = scan.t_ns;
  now.sequence = scan.sequence;
  now.coil_current_A = scan.coil_current_A;
  now.has_steps = HasSteps(scan);
  if (!now.has_steps) {
    now.stamp_lead_s = LearntLead_s(scan, previous);
    return now;
  }
  now.stamp_lead_s = 1e-9 * static_cast<double>(scan.tick_lead_ns);
  const bool follows = previous.has_steps && scan.sequence - previous.sequence == 1;
  for (std::size_t j = 0; j <= base::kStepsPerTick; ++j) {
    now.at_A[j] = follows ? previous.at_A[j + base::kStepsPerTick] : scan.step_current_A.front();
  }
  std::copy(scan.step_current_A.begin(), scan.step_current_A.end(), now.at_A.end() - base::kStepsPerTick);
  return now;
}

CoilCurrents::CoilCurrents(const base::HallScan& scan, const CurrentHistory& previous, const CurrentHistory& now,
                           double mean_age_s) noexcept
    : mean_A_(scan.coil_current_A), now_(now), mean_age_s_(mean_age_s), plausible_(ArePlausible(scan.coil_current_A)) {
  if (!plausible_) return;
  if (!now.has_steps) rate_A_s_ = RateOfMeans(scan, previous);
  for (std::size_t k = 0; k < change_A_.size(); ++k) {
    if (rate_A_s_[k] != 0) change_A_[k] = std::abs(scan.coil_current_A[k] - previous.coil_current_A[k]);
    for (std::size_t j = 1; now.has_steps && j < now.at_A.size(); ++j) {
      change_A_[k] = std::max(change_A_[k], std::abs(now.at_A[j][k] - now.at_A[j - 1][k]));
    }
  }
}

CurrentInstant CoilCurrents::At(double age_s) const noexcept {
  CurrentInstant instant;
  const double before_end_s = now_.stamp_lead_s + age_s;
  if (!now_.has_steps) {
    instant.rate_A_s = rate_A_s_;
    for (std::size_t k = 0; k < instant.current_A.size(); ++k) {
      instant.current_A[k] = mean_A_[k] + rate_A_s_[k] * (mean_age_s_ - before_end_s);
    }
    return instant;
  }
  constexpr double kLast = 2 * base::kStepsPerTick;
  const double at = std::clamp(kLast - before_end_s * kSteps_Hz, 0.0, kLast);
  const auto j = static_cast<std::size_t>(std::min(at, kLast - 1));
  const double share = at - static_cast<double>(j);
  for (std::size_t k = 0; k < instant.current_A.size(); ++k) {
    const double step_A = now_.at_A[j + 1][k] - now_.at_A[j][k];
    instant.current_A[k] = now_.at_A[j][k] + share * step_A;
    instant.rate_A_s[k] = step_A * kSteps_Hz;
  }
  return instant;
}

}  // namespace omni::tracker
