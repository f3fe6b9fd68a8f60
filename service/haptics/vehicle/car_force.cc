#include "service/haptics/vehicle/car_force.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "service/base/force_limit.h"
#include "service/base/vec.h"

namespace omni::haptics {
namespace {

constexpr double kRoomMax_N = 1e3;  // more than any device makes
constexpr double kOpposed = 1e-6;   // of a squared length: the two directions cancel
constexpr double kReserve = 0.9;    // of the headroom: the pose and the other forces change a little while a pulse runs

}  // namespace

// Along a ray the force is feasible until the coils or the length are not: |f + s d| <= F, and start + s step within
// the coils' limits, with all of the bias.
double Headroom_N(const base::ForceLimit& limit, const Vec3& others_N, const Vec3& direction) noexcept {
  if (!limit.valid || !IsWithin(others_N, 1e3) || !(limit.force_max_N > 0)) return 0;
  const base::LimitAlong length{.a = SquaredNorm(direction),
                                .b = Dot(others_N, direction),
                                .c = SquaredNorm(others_N) - limit.force_max_N * limit.force_max_N};
  if (!(length.c < 0)) return 0;
  const Vec3 start = base::Multiply(limit.ampere_per_newton, others_N);
  const Vec3 step = base::Multiply(limit.ampere_per_newton, direction);
  const std::array<double, base::kCoilCount> start_A{limit.bias_A[0] + start.x, limit.bias_A[1] + start.y,
                                                     limit.bias_A[2] + start.z};
  const std::array<double, base::kCoilCount> step_A{step.x, step.y, step.z};
  if (!(base::LargestShare(limit, start_A, step_A, 0) >= 0)) return 0;
  return std::max(0.0, base::LargestShare(limit, start_A, step_A, length.ClampToLimit(kRoomMax_N)));
}

Vec3 HitDirection(const VehicleInput& car, const Vec3& normal, const Vec3& tip) noexcept {
  const Vec3 to_base = -1 * Normalized(tip);
  const Vec3 sum = (1 - car.hit_to_base) * normal + car.hit_to_base * to_base;
  return SquaredNorm(sum) > kOpposed ? Normalized(sum) : normal;
}

double PulseAmplitude_N(const VehicleInput& car, const PulseLimits& limits, const Impact& impact) noexcept {
  // d/dt J sin(pi t / T) <= J pi / T
  const double slewable_N = std::max(0.0, limits.slew_N_s) * car.hit_duration_s / std::numbers::pi;
  const double room_N = std::min(Headroom_N(limits.device, limits.others_N, impact.normal), slewable_N);
  const double largest_N = std::min(car.hit_force_N, kReserve * room_N);
  return -largest_N * std::expm1(-(1 + impact.restitution) * impact.speed_m_s / car.hit_speed_m_s);
}

void StartPulses(const VehicleInput& car, const PulseLimits& limits, const Impacts& impacts,
                 VehicleState& state) noexcept {
  for (int i = 0; i < impacts.count; ++i) {
    const Impact& impact = impacts.of[static_cast<std::size_t>(i)];
    const double amplitude_N = PulseAmplitude_N(car, limits, impact);
    if (!(amplitude_N > 0)) continue;
    HitPulse* slot = &state.pulses[0];
    for (HitPulse& pulse : state.pulses) {
      if (slot->time_s >= 0 && (pulse.time_s < 0 || pulse.time_s > slot->time_s)) slot = &pulse;
    }
    *slot = {0, amplitude_N, impact.normal};
  }
}

// F = sum J sin(pi t / T) d, at most what fits   (8.11), (8.12)
PulseForce AdvancePulses(const VehicleInput& car, const PulseLimits& limits, double dt_s,
                         VehicleState& state) noexcept {
  PulseForce sum;
  for (HitPulse& pulse : state.pulses) {
    if (!(pulse.time_s >= 0)) continue;
    pulse.time_s += dt_s;
    if (!(pulse.time_s < car.hit_duration_s)) {
      pulse = {};
      continue;
    }
    const double share = std::sin(std::numbers::pi * pulse.time_s / car.hit_duration_s);
    sum.force_N = sum.force_N + (share * pulse.amplitude_N) * pulse.direction;
    sum.share = std::max(sum.share, share);
  }
  const double size_N = Norm(sum.force_N);
  if (!(size_N > 0)) return {{}, sum.share};
  const double room_N = Headroom_N(limits.device, limits.others_N, (1 / size_N) * sum.force_N);
  if (room_N < size_N) sum.force_N = (room_N / size_N) * sum.force_N;
  return sum;
}

namespace {

constexpr double kFade_Hz = 100;    // full below; none at kRoadForceMax_Hz, where the coils stop following
constexpr double kIdleShare = 0.3;  // of the engine's frequency at top speed
constexpr double kFullAt = 0.25;    // share of the top speed at which the road has its full force

double Wave(double frequency_Hz, double dt_s, double& turns) noexcept {
  turns = std::fmod(turns + frequency_Hz * dt_s, 1.0);
  const double fade = std::clamp((kRoadForceMax_Hz - frequency_Hz) / (kRoadForceMax_Hz - kFade_Hz), 0.0, 1.0);
  return fade * std::sin(2 * std::numbers::pi * turns);
}

}  // namespace

// Engine: A s sin(2 pi f t), f = f_max (0.3 + 0.7 s), s = speed / top speed. Road: B min(1, 4 s) sin(2 pi x / lambda)
// over the distance x   (8.13), (8.14)
double RoadForce_N(const VehicleInput& car, double dt_s, VehicleState& state) noexcept {
  const double speed_m_s = Norm(state.velocity_base_m_s);
  const double share = std::min(1.0, speed_m_s / car.speed_max_m_s);
  if (!(share > 0)) return 0;
  const double engine_Hz = car.engine_frequency_Hz * (kIdleShare + (1 - kIdleShare) * share);
  const double engine_N = car.engine_force_N * share * Wave(engine_Hz, dt_s, state.engine_turns);
  const double road_N = car.road_force_N * std::min(1.0, share / kFullAt) *
                        Wave(speed_m_s / car.road_wavelength_m, dt_s, state.road_turns);
  return std::clamp(engine_N + road_N, -kRoadForceMax_N, kRoadForceMax_N);
}

}  // namespace omni::haptics
