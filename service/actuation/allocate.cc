#include <algorithm>
#include <cmath>

#include "service/actuation/actuation.h"

namespace omni::actuation {
namespace {

using Currents = std::array<double, base::kCoilCount>;

constexpr double kForceMax_N = 1e6;  // a larger request is a mistake, like one that is not a number
constexpr double kStepMax_s = 0.1;   // a longer or senseless step counts as one tick

double Square(double x) { return x * x; }

// 0 at 0, 1 from `width` on, slope 0 at both ends.
double SmoothStep(double x, double width) noexcept {
  const double t = width > 0 ? std::clamp(x / width, 0.0, 1.0) : 1.0;
  return t * t * (3 - 2 * t);
}

bool AreFinite(const Currents& currents) noexcept {
  return std::all_of(currents.begin(), currents.end(), [](double current) { return std::isfinite(current); });
}

void Scale(double factor, Currents& currents) noexcept {
  for (double& current : currents) current *= factor;
}

// With copper at its maximum temperature: never optimistic.
double HotResistance(const Config& config, std::size_t k) noexcept {
  return config.resistance_20C_ohm[k] * (1 + kCopperPerKelvin * (config.temperature_max_C - 20));
}

double Power_W(const Config& config, const Currents& currents) noexcept {
  double power_W = 0;
  for (std::size_t k = 0; k < currents.size(); ++k) power_W += HotResistance(config, k) * Square(currents[k]);
  return power_W;
}

// Largest t in [0, 1] with the heat of (held + t current) within the limit: a t^2 + 2 b t + c <= P. Scaling only the
// request keeps the direction of the net force.
double PowerScale(const Config& config, const Currents& held_A, const Currents& current_A) noexcept {
  double a = 0, b = 0, c = 0;
  for (std::size_t k = 0; k < held_A.size(); ++k) {
    const double hot = HotResistance(config, k);
    a += hot * current_A[k] * current_A[k];
    b += hot * current_A[k] * held_A[k];
    c += hot * held_A[k] * held_A[k];
  }
  if (a + 2 * b + c <= config.power_max_W) return 1;
  const double room = b * b - a * (c - config.power_max_W);
  if (!(a > 0 && room >= 0)) return 0;
  return std::clamp((std::sqrt(room) - b) / a, 0.0, 1.0);
}

// A f
Currents Push(const base::ForceLimit& limit, const base::Vec3& force_N) noexcept {
  Currents push{};
  for (std::size_t k = 0; k < push.size(); ++k) {
    const double* row = &limit.ampere_per_newton[3 * k];
    push[k] = row[0] * force_N.x + row[1] * force_N.y + row[2] * force_N.z;
  }
  return push;
}

// The current besides the request while a force of this size is rendered: w(|f|) b.
Currents Held(const Config& config, const base::ForceLimit& limit, double force_N) noexcept {
  Currents held{};
  const double share = SmoothStep(force_N, config.bias_fade_N);
  for (std::size_t k = 0; k < held.size(); ++k) held[k] = share * limit.bias_A[k] + 0.0;  // never -0
  return held;
}

// I = s A f + w(|s f|) b: the request scaled as a vector, and the share of the snapping compensation that goes
// with it. docs/theory/actuation.md (7), (8)
Currents Scaled(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N) noexcept {
  double scale = base::FeasibleScale(limit, force_N);
  const double norm_N = Norm(force_N);
  Currents push = Push(limit, force_N);
  Scale(scale, push);
  const double cooler = PowerScale(config, Held(config, limit, scale * norm_N), push);
  scale *= cooler;
  const Currents held = Held(config, limit, scale * norm_N);
  for (std::size_t k = 0; k < push.size(); ++k) push[k] = cooler * push[k] + held[k];
  return push;
}

Currents Wanted(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N) noexcept {
  if (!limit.valid || !(Norm(force_N) <= kForceMax_N)) return {};
  const Currents wanted = Scaled(config, limit, force_N);
  return AreFinite(wanted) ? wanted : Currents{};
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
void ApplyLimits(const Config& config, const Currents& ceiling, Currents& currents) noexcept {
  double factor = 1;
  for (std::size_t k = 0; k < currents.size(); ++k) {
    if (!(std::abs(currents[k]) * factor <= ceiling[k])) factor = ceiling[k] / std::abs(currents[k]);
  }
  Scale(factor, currents);
  const double power_W = Power_W(config, currents);
  if (!(power_W <= config.power_max_W)) Scale(std::sqrt(config.power_max_W / power_W), currents);
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

// From what falling alone leaves of `last` straight towards `target`, as far as coils slew and the force may grow. (13)
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

// Largest t in [0, 1] with |t g + snap| <= most, where |snap| <= most: a t^2 + 2 b t + c <= 0.
double ShareWithin(const base::Vec3& g, const base::Vec3& snap, double most_N) noexcept {
  const double a = SquaredNorm(g);
  const double b = Dot(g, snap);
  const double c = SquaredNorm(snap) - Square(most_N);
  if (a + 2 * b + c <= 0) return 1;
  return a > 0 ? std::clamp((std::sqrt(std::max(0.0, b * b - a * c)) - b) / a, 0.0, 1.0) : 0.0;
}

// At the pen's new pose the previous tick's currents make another force: they are scaled until their force has grown no
// more than allowed, and the force on the tool, core's pull included, is within the limit.   (14)
void ApplyForceLimit(const base::ForceLimit& limit, double last_force_N, Currents& currents) noexcept {
  if (!limit.valid) return;
  const base::Vec3 coils_N = CoilForce(limit, currents);
  const double size_N = Norm(coils_N);
  double share = ShareWithin(coils_N, limit.snapping_N, std::max(limit.force_max_N, Norm(limit.snapping_N)));
  if (!(size_N * share <= last_force_N + limit.force_rise_N)) share = (last_force_N + limit.force_rise_N) / size_N;
  if (!(share >= 1)) Scale(share, currents);
}

}  // namespace

void Allocate(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N, double dt_s, State& state,
              base::CoilCurrents& currents) noexcept {
  const double step_s = dt_s >= 0 && dt_s <= kStepMax_s ? dt_s : base::kTickPeriod_s;
  const Currents last = AreFinite(state.last_current_A) ? state.last_current_A : Currents{};
  const Currents ceiling = Ceiling(config, limit);

  Currents target = Wanted(config, limit, force_N);
  ApplyLimits(config, ceiling, target);
  Currents next = Slew(config, limit, last, target, step_s);
  ApplyLimits(config, ceiling, next);  // `last` may lie beyond a limit that has shrunk
  ApplyForceLimit(limit, state.last_force_N, next);
  for (std::size_t k = 0; k < next.size(); ++k) next[k] = std::clamp(next[k], -ceiling[k], ceiling[k]);  // rounding
  if (!AreFinite(next)) next = {};
  state.last_current_A = next;
  state.last_force_N = limit.valid ? Norm(CoilForce(limit, next)) : 0;
  currents.current_A = next;
}

}  // namespace omni::actuation
