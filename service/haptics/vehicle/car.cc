#include "service/haptics/vehicle/car.h"

#include <span>

#include "service/base/force_limit.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car_force.h"
#include "service/haptics/vehicle/car_motion.h"

namespace omni::haptics {
namespace {

constexpr double kStickShare = 2.0 / 3;  // of the device's force; the rest is kept for hits

// The stick's spring as far as it leaves room for hits   (8.12)
Vec3 LeaveRoom(const base::ForceLimit& limit, const Vec3& stick_N) noexcept {
  const double size_N = Norm(stick_N);
  const double most_N = kStickShare * base::ForceMax_N(limit, stick_N);
  return size_N > most_N ? (most_N / size_N) * stick_N : stick_N;
}

VehicleReport ReportOf(const VehicleState& state) noexcept {
  const double speed_m_s =
      state.velocity_base_m_s.x * std::cos(state.heading_rad) + state.velocity_base_m_s.y * std::sin(state.heading_rad);
  return {true,
          state.sliding,
          state.hits,
          state.lap.laps,
          state.position_base_m,
          state.heading_rad,
          speed_m_s,
          state.lap.running ? state.lap.time_s : 0,
          state.lap.last_s,
          state.lap.best_s};
}

}  // namespace

void StartCar(const VehicleInput& car, VehicleState& state) noexcept {
  state = {};
  state.position_base_m = car.start_base_m;
  state.heading_rad = car.start_heading_rad;
  state.started = true;
}

Impacts DriveCar(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials,
                 const Thumbstick& stick, double dt_s, VehicleState& state) noexcept {
  Accelerate(car, stick, dt_s, state);
  const Vec3 before = state.position_base_m;
  const Impacts impacts = MoveCar(car, walls, materials, dt_s, state);
  AdvanceLap(car, before, state.position_base_m, dt_s, state.lap);
  return impacts;
}

Vec3 StepVehicle(const Config& config, const StiffnessBound& bound, const Scene& scene, const Input& input,
                 const Vec3& contacts_N, State& state, Output& output) noexcept {
  const SceneHeader& header = scene.header();
  Vec3 stick_N;
  Thumbstick stick;
  if (header.has_joystick != 0 && input.tracked) {
    stick = JoystickDeflection(header.joystick, input.device_point_base_m);
    stick_N = JoystickForce(header.joystick, header.detent_curvature_N_m, bound, input);
    output.tip_normal_force_N += state.ramp * std::max(0.0, stick_N.z);  // pushing the stick down is a press
    output.joystick = true;
    output.thumbstick_x = stick.x;
    output.thumbstick_y = stick.y;
  }
  if (header.has_vehicle == 0) return stick_N;
  const VehicleInput& car = header.vehicle;
  if (!state.vehicle.started) StartCar(car, state.vehicle);
  Impacts impacts = DriveCar(car, WallsOf(scene), scene.materials(), stick, input.dt_s, state.vehicle);
  output.vehicle = ReportOf(state.vehicle);
  if (input.limit.valid) stick_N = LeaveRoom(input.limit, stick_N);
  const PulseLimits limits{input.limit, contacts_N + stick_N, config.force_slew_N_s};
  for (Impact& impact : std::span(impacts.of).first(static_cast<std::size_t>(impacts.count))) {
    impact.normal = HitDirection(car, impact.normal, input.device_point_base_m);
  }
  StartPulses(car, limits, impacts, state.vehicle);
  const PulseForce pulse = AdvancePulses(car, limits, input.dt_s, state.vehicle);
  const double road_N = (1 - pulse.share) * RoadForce_N(car, input.dt_s, state.vehicle);
  return stick_N + pulse.force_N + Vec3{0, 0, road_N};
}

}  // namespace omni::haptics
