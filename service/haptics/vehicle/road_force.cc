#include "service/haptics/vehicle/road_force.h"

#include <numbers>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;
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
