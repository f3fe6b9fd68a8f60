// The coils' currents at each sensor's own instant: interpolated between the control steps where the base reports them,
// else along the straight line from one tick's mean to the next. docs/theory/tracking.md (4.1)
#pragma once

#include <array>
#include <cstdint>

#include "service/base/hall_scan.h"

namespace omni::tracker {

using Currents = std::array<double, base::kCoilCount>;

// False: a value that no current can have.
bool ArePlausible(const Currents& current_A) noexcept;

// State kept from earlier scans: sensors' samples are up to two ticks old.
struct CurrentHistory {
  bool valid = false;
  std::int64_t t_ns = 0;
  std::uint64_t sequence = 0;
  Currents coil_current_A{};                                 // mean over the tick
  double stamp_lead_s = 0;                                   // end of the device's tick minus t_ns
  bool has_steps = false;                                    // of the last scan
  std::array<Currents, 2 * base::kStepsPerTick + 1> at_A{};  // at ends of control steps; the last at the tick's end
};

// The history after `scan`. A base that does not report its control steps does not report the end of its ticks either:
// it is inferred from the latest stamps of the past second.
CurrentHistory UpdatedHistory(const base::HallScan& scan, const CurrentHistory& previous) noexcept;

struct CurrentInstant {
  Currents current_A{}, rate_A_s{};
};

// Of one scan.
class CoilCurrents {
 public:
  // `now` = UpdatedHistory(scan, previous); all outlive this. `mean_age_s`: means lie this long before the tick's end.
  CoilCurrents(const base::HallScan& scan, const CurrentHistory& previous, const CurrentHistory& now,
               double mean_age_s) noexcept;

  bool plausible() const noexcept { return plausible_; }

  // `age_s` before the scan's stamp.
  CurrentInstant At(double age_s) const noexcept;

  // How fast the currents change: the largest change of a control step, or that of the mean since the previous scan.
  const Currents& change_A() const noexcept { return change_A_; }

 private:
  const Currents& mean_A_;
  const CurrentHistory& now_;
  double mean_age_s_;
  Currents rate_A_s_{};  // of the means
  Currents change_A_{};
  bool plausible_;
};

}  // namespace omni::tracker
