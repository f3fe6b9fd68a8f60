// A ring road between two walls, and drivers for it.
#pragma once

#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car.h"
#include "service/haptics/vehicle/car_motion.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {

// Two coaxial tubes, 3 mm high, and a floor that is no wall. Radius of the road's middle: 40 mm.
inline SceneInput Ring(double restitution = 0) {
  SceneInput input;
  input.name = "ring";
  input.materials.emplace_back().restitution = restitution;
  for (const double radius_m : {0.03, 0.05}) {
    InputObject wall = Periodic(64, 4, [=](double u, double v) {
      const int corner = static_cast<int>(std::lround(v / (0.5 * std::numbers::pi)));  // of the rectangular section
      const double r = radius_m + (corner == 0 || corner == 3 ? 0.0005 : -0.0005);
      return Vec3{r * std::cos(u), r * std::sin(u), corner < 2 ? 0.003 : 0.0};
    });
    wall.car_wall = true;
    input.objects.push_back(wall);
  }
  InputObject floor = Block(2, {0.06, 0.06, 0.001}, {0, 0, -0.001});
  floor.car_wall = true;
  input.objects.push_back(floor);
  input.joystick.emplace().centre_base_m = {0, 0, 0.03};
  VehicleInput& car = input.vehicle.emplace();
  car.start_base_m = {0.04, 0, 0.0015};
  car.start_heading_rad = std::numbers::pi / 2;
  car.line_width_m = 0.02;
  return input;
}

// The same with checkpoints at the other three quarters.
inline SceneInput RingWithCheckpoints() {
  SceneInput input = Ring();
  for (int k = 1; k <= 3; ++k) {
    const double angle = 0.5 * std::numbers::pi * k;
    input.vehicle->checkpoints[static_cast<std::size_t>(k - 1)] = {
        {0.04 * std::cos(angle), 0.04 * std::sin(angle), 0}, angle + 0.5 * std::numbers::pi, 0.02};
  }
  input.vehicle->checkpoint_count = 3;
  return input;
}

// A car in a scene, a tick at a time.
class Driver {
 public:
  explicit Driver(Scene scene) : scene_(std::move(scene)), walls_(WallsOf(scene_)) { StartCar(car(), state); }

  Impacts Go(const Thumbstick& stick, int ticks = 1) {
    Impacts last;
    for (int k = 0; k < ticks; ++k) {
      const Impacts impacts = DriveCar(car(), walls_, scene_.materials(), stick, 1e-3, state);
      if (impacts.count > 0) last = impacts;
    }
    return last;
  }
  Impacts Coast(double dt_s = 1e-3) { return MoveCar(car(), walls_, scene_.materials(), dt_s, state); }

  // Along the middle of the ring; direction -1: the wrong way round. Steers by its position and heading.
  Impacts Follow(double throttle, int direction = 1) {
    const Vec3 p = state.position_base_m;
    const double angle = std::atan2(p.y, p.x), off_m = std::hypot(p.x, p.y) - 0.04;
    const double wanted = angle + direction * (std::numbers::pi / 2 + std::clamp(60 * off_m, -0.6, 0.6));
    const double error = std::remainder(wanted - state.heading_rad, 2 * std::numbers::pi);
    return Go({std::clamp(-2 * error, -1.0, 1.0), throttle});
  }
  double Speed() const { return Norm(state.velocity_base_m_s); }
  const VehicleInput& car() const { return scene_.header().vehicle; }
  const WallMap& walls() const { return walls_; }
  const Scene& scene() const { return scene_; }

  VehicleState state;

 private:
  Scene scene_;
  WallMap walls_;
};

// No walls, so that nothing ends a drive.
inline Scene Plain(const VehicleInput& car) {
  SceneInput input = SceneOf(Block(1, {0.001, 0.001, 0.001}, {5, 5, 5}));
  input.vehicle = car;
  return Built(input);
}

}  // namespace omni::haptics
