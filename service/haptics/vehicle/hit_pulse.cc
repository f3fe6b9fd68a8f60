#include "service/haptics/vehicle/hit_pulse.h"

#include <numbers>

#include "service/base/force_limit.h"

namespace omni::haptics {
namespace {

constexpr double kReserve = 0.9;  // of the headroom: the pose and the other forces change a little while a pulse runs

}  // namespace

// Along a ray the force is feasible until the first coil or the length is: |I_k + s dI_k| <= max_k, |f + s d| <= F.
double Headroom_N(const base::ForceLimit& limit, const Vec3& others_N, const Vec3& direction) noexcept {
  if (!limit.valid || !Within(others_N, 1e3) || !(limit.force_max_N > 0)) return 0;
  // s^2 + 2 s (f . d) + f^2 - F^2 = 0
  const double along = Dot(others_N, direction);
  const double inside = limit.force_max_N * limit.force_max_N - SquaredNorm(others_N);
  if (!(inside > 0)) return 0;
  double room_N = std::sqrt(along * along + inside) - along;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const double* row = &limit.ampere_per_newton[3 * k];
    const Vec3 ampere_per_newton{row[0], row[1], row[2]};
    const double present_A = limit.bias_A[k] + Dot(ampere_per_newton, others_N);
    const double gain = Dot(ampere_per_newton, direction);
    const double left_A = limit.current_max_A[k] - (gain > 0 ? present_A : -present_A);
    if (!(left_A > 0 && std::abs(present_A) <= limit.current_max_A[k])) return 0;
    if (std::abs(gain) * room_N > left_A) room_N = left_A / std::abs(gain);
  }
  return room_N >= 0 ? room_N : 0;
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

// F = sum J sin(pi t / T) n, at most what fits   (8.11), (8.12)
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

}  // namespace omni::haptics
