// The pen as a joystick, the car and its walls.
#include <gtest/gtest.h>

#include "service/haptics/vehicle/car.h"
#include "tests/unit/haptics_story.h"

namespace omni::haptics {
namespace {

// A closed ring of walls around the car: two coaxial tubes, 3 mm high, and a floor that is no wall.
SceneInput Ring() {
  SceneInput input;
  input.name = "ring";
  input.materials.emplace_back();
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
  return input;
}

TEST(Joystick, SpringPullsBackOutsideTheDeadZone) {
  Pen pen(Built(Ring()));
  pen.MoveTo({0.001, 0, 0.03});
  pen.Rest(3);
  EXPECT_EQ(Norm(pen.output.force_base_N), 0);
  EXPECT_EQ(pen.output.thumbstick_x, 0);
  pen.Slide({0.001, 0, 0.03}, {0, 0.00825, 0.03}, 50);
  pen.Rest(5);
  EXPECT_TRUE(pen.output.joystick);
  EXPECT_NEAR(pen.output.thumbstick_y, 0.5, 1e-9);
  EXPECT_NEAR(pen.output.force_base_N.y, -60 * (0.00825 - 0.0015), 1e-9);
  pen.Slide({0, 0.00825, 0.03}, {0.03, 0.03, 0.04}, 100);
  EXPECT_NEAR(std::hypot(pen.output.thumbstick_x, pen.output.thumbstick_y), 1, 1e-9);
  EXPECT_LT(pen.output.force_base_N.z, -0.1) << "the spring is three-dimensional";
}

TEST(Car, DrivesBrakesAndReverses) {
  const Scene scene = Built(Ring());
  const VehicleInput car = scene.header().vehicle;
  const Surface surface(scene, {});
  VehicleState state;
  StartCar(car, state);
  for (int k = 0; k < 100; ++k) DriveCar(car, scene, surface, {0, 1}, 1e-3, state);
  EXPECT_NEAR(state.speed_m_s, 0.015, 1e-9);
  EXPECT_NEAR(state.position_base_m.y, 0.5 * 0.15 * 0.01, 2e-5);
  for (int k = 0; k < 51; ++k) DriveCar(car, scene, surface, {0, -1}, 1e-3, state);
  EXPECT_LE(state.speed_m_s, 0);
  for (int k = 0; k < 1000; ++k) DriveCar(car, scene, surface, {0, -1}, 1e-3, state);
  EXPECT_NEAR(state.speed_m_s, -0.3 * car.speed_max_m_s, 1e-9);
}

TEST(Car, SteersRightForARightThumbstick) {
  const Scene scene = Built(Ring());
  const VehicleInput car = scene.header().vehicle;
  const Surface surface(scene, {});
  VehicleState state;
  StartCar(car, state);
  for (int k = 0; k < 100; ++k) DriveCar(car, scene, surface, {0.3, 1}, 1e-3, state);
  EXPECT_LT(state.heading_rad, car.start_heading_rad);
}

TEST(Car, LapsAreCountedOnce) {
  SceneInput input = Ring();
  const Scene scene = Built(input);
  const VehicleInput car = scene.header().vehicle;
  const Surface surface(scene, {});
  VehicleState state;
  StartCar(car, state);
  // Steering that follows the middle of the ring.
  for (int k = 0; k < 20'000 && state.laps < 2; ++k) {
    const double angle = std::atan2(state.position_base_m.y, state.position_base_m.x);
    const double off = std::hypot(state.position_base_m.x, state.position_base_m.y) - 0.04;
    const double wanted = angle + std::numbers::pi / 2 + std::clamp(100 * off, -0.6, 0.6);
    const double error = std::remainder(wanted - state.heading_rad, 2 * std::numbers::pi);
    DriveCar(car, scene, surface, {std::clamp(-2 * error, -0.7, 0.7), 0.7}, 1e-3, state);
  }
  EXPECT_EQ(state.laps, 2U);
  EXPECT_EQ(state.hits, 0U);
}

TEST(Car, NeverLeavesAClosedRingAtAnySpeed) {
  const Scene scene = Built(Ring());
  const VehicleInput car = scene.header().vehicle;
  const Surface surface(scene, {});
  Random random(5);
  for (const double speed_m_s : {0.05, 0.5, 5.0, 50.0, 500.0}) {
    VehicleState state;
    StartCar(car, state);
    for (int k = 0; k < 2000; ++k) {
      if (k % 7 == 0) {
        state.heading_rad = random.Uniform(-3.2, 3.2);
        state.speed_m_s = random.Uniform(-speed_m_s, speed_m_s);
      }
      MoveCar(car, scene, surface, random.Uniform(0, 5e-3), state);
      const double r = std::hypot(state.position_base_m.x, state.position_base_m.y);
      ASSERT_GT(r, 0.0305 + 0.8 * car.radius_m) << speed_m_s;
      ASSERT_LT(r, 0.0495 - 0.8 * car.radius_m) << speed_m_s;
      ASSERT_EQ(state.position_base_m.z, car.start_base_m.z);
    }
    EXPECT_GT(state.hits, 0U);
  }
}

double PulsePeak(const Scene& scene, double speed_m_s) {
  const VehicleInput& car = scene.header().vehicle;
  const Surface surface(scene, {});
  VehicleState state;
  StartCar(car, state);
  state.heading_rad = 0;
  state.speed_m_s = speed_m_s;
  double peak_N = 0;
  for (int k = 0; k < 400; ++k) {
    MoveCar(car, scene, surface, 1e-3, state);
    const Vec3 force = PulseForce(car, 1e-3, state);
    EXPECT_LE(force.x, 0) << "away from the wall";
    peak_N = std::max(peak_N, Norm(force));
  }
  EXPECT_EQ(state.hits, 1U);
  EXPECT_LT(state.speed_m_s, 1e-3) << "the speed into the wall is gone";
  return peak_N;
}

TEST(Car, HitsAreMonotoneInSpeedAndBounded) {
  const Scene scene = Built(Ring());
  double last_N = 0;
  for (int k = 0; k < 20; ++k) {
    const double peak_N = PulsePeak(scene, 0.05 * std::pow(20.0, k / 19.0));
    EXPECT_LE(peak_N, scene.header().vehicle.hit_force_N * (1 + 1e-12));
    EXPECT_GT(peak_N, last_N);
    last_N = peak_N;
  }
}

TEST(Car, APenPushedForwardDrivesItIntoTheWallAndFeelsIt) {
  Pen pen(Built(Ring()));
  pen.MoveTo({0, 0, 0.03});
  pen.Slide({0, 0, 0.03}, {0, 0.015, 0.03}, 50);
  double strongest_N = 0;
  for (int k = 0; k < 1500; ++k) {
    const bool before = pen.state.vehicle.hits > 0;
    pen.Rest(1);
    if (before || pen.state.vehicle.hits > 0) strongest_N = std::max(strongest_N, Norm(pen.output.force_base_N));
  }
  EXPECT_GE(pen.state.vehicle.hits, 1U);
  EXPECT_GT(strongest_N, 0.9) << "spring 0.81 N and the pulse";
}

TEST(Car, AStartInAWallIsReported) {
  SceneInput input = Ring();
  input.vehicle->start_base_m.x = 0.049;
  BuildReport report;
  ASSERT_TRUE(BuildScene(input, report).ok());
  bool said = false;
  for (const std::string& line : report.lines) said = said || line.find("vehicle: starts") != std::string::npos;
  EXPECT_TRUE(said);
}

}  // namespace
}  // namespace omni::haptics
