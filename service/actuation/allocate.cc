#include <algorithm>
#include <cmath>

#include "service/actuation/actuation.h"

namespace omni::actuation {
namespace {

using Currents = std::array<double, base::kCoilCount>;

constexpr double kStepMax_s = 0.1;  // a longer or senseless step counts as one tick

double Square(double x) { return x * x; }

bool AreFinite(const Currents& currents) noexcept {
  return std::all_of(currents.begin(), currents.end(), [](double current) { return std::isfinite(current); });
}

void Scale(double factor, Currents& currents) noexcept {
  for (double& current : currents) current *= factor;
}

struct Wanted {
  Currents current_A{};
  base::Vec3 force_N;  // that they make, core's pull compensated
};

// I = s A f + w(|s f|) b: the request scaled as a vector, and the share of the snapping compensation that goes
// with it. docs/theory/actuation.md (4.1), (4.2)
Wanted WantedFor(const base::ForceLimit& limit, const base::Vec3& force_N) noexcept {
  const double scale = base::FeasibleScale(limit, force_N);
  if (force_N == base::Vec3{} || !(scale > 0)) return {};
  const base::Vec3 feasible_N = scale * force_N;
  const Wanted wanted{base::CurrentsFor_A(limit, feasible_N), base::Rendered_N(limit, feasible_N)};
  return AreFinite(wanted.current_A) ? wanted : Wanted{};
}

// What each coil may carry now: the device's limit, and the pose's while that is valid.
Currents Ceiling(const Config& config, const base::ForceLimit& limit) noexcept {
  Currents ceiling{};
  for (std::size_t k = 0; k < ceiling.size(); ++k) {
    const double derated = limit.valid ? limit.current_max_A[k] : config.current_max_A;
    ceiling[k] = derated >= 0 ? std::min(derated, config.current_max_A) : 0.0;
  }
  return ceiling;
}

// Shrinks the vector until every coil and the total power fit: the direction of the currents stays.
void ApplyLimits(const base::ForceLimit& limit, const Currents& ceiling, Currents& currents) noexcept {
  double factor = 1;
  for (std::size_t k = 0; k < currents.size(); ++k) {
    if (!(std::abs(currents[k]) * factor <= ceiling[k])) factor = ceiling[k] / std::abs(currents[k]);
  }
  Scale(factor, currents);
  const double power_W = base::Power_W(limit, currents);
  if (!(power_W <= limit.power_max_W)) Scale(std::sqrt(limit.power_max_W / power_W), currents);
}

// X I
base::Vec3 CoilForce(const base::ForceLimit& limit, const Currents& currents) noexcept {
  const double* X = limit.newton_per_ampere.data();
  const auto row = [&](int i) { return X[i] * currents[0] + X[i + 1] * currents[1] + X[i + 2] * currents[2]; };
  return {row(0), row(3), row(6)};
}

// What remains of `last` towards `target` by falling alone: its share that comes nearest.
double ShareKept(const Currents& last, const Currents& target) noexcept {
  double along = 0, whole = 0;
  for (std::size_t k = 0; k < last.size(); ++k) {
    along += last[k] * target[k];
    whole += Square(last[k]);
  }
  return along > 0 ? std::min(1.0, along / whole) : 0.0;
}

// From what falling alone leaves of `last` straight towards `target`, as far as coils slew and the force may grow.
// (6.1)
Currents Slew(const Config& config, const base::ForceLimit& limit, const Currents& last, const Currents& target,
              double dt_s) noexcept {
  const double kept = ShareKept(last, target);
  Currents step{};
  double largest = 0;
  for (std::size_t k = 0; k < last.size(); ++k) {
    step[k] = target[k] - kept * last[k];
    largest = std::max(largest, std::abs(step[k]));
  }
  const double growth_N = Norm(CoilForce(limit, step));
  double share = 1;
  if (!(largest <= config.current_slew_A_s * dt_s)) share = config.current_slew_A_s * dt_s / largest;
  if (!(growth_N * share <= limit.force_rise_N)) share = limit.force_rise_N / growth_N;
  if (share == 1) return target;
  Currents moved{};
  for (std::size_t k = 0; k < last.size(); ++k) moved[k] = kept * last[k] + share * step[k];
  return moved;
}

// At the pen's new pose the previous tick's currents make another force: they are scaled until their force has grown no
// more than allowed, and the force on the tool, core's pull included, is within the limit.   (6.2)
void ApplyForceLimit(const base::ForceLimit& limit, double last_force_N, Currents& currents) noexcept {
  if (!limit.valid) return;
  const base::Vec3 coils_N = CoilForce(limit, currents);
  const double size_N = Norm(coils_N);
  const double pull_N2 = SquaredNorm(limit.snapping_N);
  const base::LimitAlong net{.a = size_N * size_N,
                             .b = Dot(coils_N, limit.snapping_N),
                             .c = std::min(0.0, pull_N2 - Square(limit.force_max_N))};
  double share = std::max(0.0, net.ClampToLimit(1));
  if (!(size_N * share <= last_force_N + limit.force_rise_N)) share = (last_force_N + limit.force_rise_N) / size_N;
  if (!(share >= 1)) Scale(share, currents);
}

}  // namespace

base::Vec3 Allocate(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N, double dt_s,
                    State& state, base::CoilCurrents& currents) noexcept {
  const double step_s = dt_s >= 0 && dt_s <= kStepMax_s ? dt_s : base::kTickPeriod_s;
  const Currents last = AreFinite(state.last_current_A) ? state.last_current_A : Currents{};
  const Currents ceiling = Ceiling(config, limit);

  const Wanted wanted = WantedFor(limit, force_N);
  Currents next = Slew(config, limit, last, wanted.current_A, step_s);
  ApplyLimits(limit, ceiling, next);  // `last` may lie beyond a limit that has shrunk
  ApplyForceLimit(limit, state.last_force_N, next);
  for (std::size_t k = 0; k < next.size(); ++k) next[k] = std::clamp(next[k], -ceiling[k], ceiling[k]);  // rounding
  if (!AreFinite(next)) next = {};
  state.last_current_A = next;
  state.last_force_N = limit.valid ? Norm(CoilForce(limit, next)) : 0;
  currents.current_A = next;
  if (next == wanted.current_A) return wanted.force_N;
  return wanted.force_N + CoilForce(limit, next) - CoilForce(limit, wanted.current_A);
}

}  // namespace omni::actuation
