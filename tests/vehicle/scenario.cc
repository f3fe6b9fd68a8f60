// The pen as a joystick, the car and its walls, and their forces on the pen.
#include <gtest/gtest.h>

#include "service/base/force_limit.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car_force.h"
#include "tests/vehicle/scene.h"

namespace omni::haptics {
namespace test_vehicle_scenario {

TEST(Joystick, SpringPullsBackOutsideTheDeadZone) {
  SceneInput input = Ring();
  input.vehicle.reset();
  Pen pen(Built(input));
  pen.MoveTo({0.001, 0, 0.03});
  pen.Rest(3);
  EXPECT_EQ(Norm(pen.output.force_base_N), 0);
  EXPECT_EQ(pen.output.thumbstick_x, 0);
  pen.Slide({0.001, 0, 0.03}, {0, 0.00825, 0.03}, 50);
  pen.Rest(5);
  EXPECT_TRUE(pen.output.joystick);
  EXPECT_FALSE(pen.output.vehicle.on);
  EXPECT_NEAR(pen.output.thumbstick_y, 0.5, 1e-9);
  EXPECT_NEAR(pen.output.force_base_N.y, -60 * (0.00825 - 0.0015), 1e-9);
  pen.Slide({0, 0.00825, 0.03}, {0.03, 0.03, 0.04}, 100);
  EXPECT_NEAR(std::hypot(pen.output.thumbstick_x, pen.output.thumbstick_y), 1, 1e-9);
  EXPECT_LT(pen.output.force_base_N.z, -0.1) << "the spring is three-dimensional";
}

TEST(Car, NeverLeavesAClosedRingAtAnySpeed) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    Driver driver(Built(Ring(restitution)));
    Random random(5);
    for (const double speed_m_s : {0.05, 0.5, 5.0, 50.0, 500.0}) {
      StartCar(driver.car(), driver.state);
      for (int k = 0; k < 2000; ++k) {
        if (k % 7 == 0) {
          driver.state.heading_rad = random.Uniform(-3.2, 3.2);
          driver.state.velocity_base_m_s = {random.Uniform(-speed_m_s, speed_m_s),
                                            random.Uniform(-speed_m_s, speed_m_s), 0};
        }
        driver.Coast(random.Uniform(0, 5e-3));
        const double r = std::hypot(driver.state.position_base_m.x, driver.state.position_base_m.y);
        // Between the walls' polygons: the outer one's sagitta is 0.06 mm.
        ASSERT_GT(r, (0.0305 + driver.car().radius_m) * std::cos(std::numbers::pi / 64) - 1e-6) << speed_m_s;
        ASSERT_LT(r, 0.0495 - driver.car().radius_m + 1e-6) << speed_m_s;
        ASSERT_EQ(driver.state.position_base_m.z, driver.car().start_base_m.z);
      }
      EXPECT_TRUE(speed_m_s < 0.1 || driver.state.hits > 0);
    }
  }
}

TEST(Car, LosesNormalSpeedAtAWallButNotTangential) {
  Driver driver(Built(Ring()));
  const double middle = std::numbers::pi / 64;  // of a facet
  const Vec3 out{std::cos(middle), std::sin(middle), 0};
  driver.state.position_base_m = {0.04 * out.x, 0.04 * out.y, 0.0015};
  driver.state.heading_rad = middle;
  driver.state.velocity_base_m_s = 0.5 * out;
  for (int k = 0; k < 50; ++k) driver.Coast();
  EXPECT_EQ(driver.state.hits, 1U);
  EXPECT_LT(driver.Speed(), 1e-3) << "head on";
  StartCar(driver.car(), driver.state);
  driver.state.heading_rad = 0.25 * std::numbers::pi;
  driver.state.velocity_base_m_s = {0.05, 0.05, 0};
  for (int k = 0; k < 400; ++k) driver.Coast();
  EXPECT_EQ(driver.state.hits, 1U) << "leaning on it is no further hit";
  EXPECT_GT(driver.Speed(), 0.03) << "askew";
}

TEST(Car, WallTurnsTheCarAlongIt) {
  SceneInput input = Ring();
  Driver driver(Built(input));
  driver.state.heading_rad = std::numbers::pi / 2 - 0.5;  // half a radian towards the outer wall
  driver.Go({0, 1}, 1500);
  EXPECT_GE(driver.state.hits, 1U);
  const Vec3 p = driver.state.position_base_m;
  const double along = std::atan2(p.y, p.x) + std::numbers::pi / 2;
  EXPECT_LT(std::abs(std::remainder(driver.state.heading_rad - along, 2 * std::numbers::pi)), 0.3);
  EXPECT_GT(driver.Speed(), 0.03) << "it drives on along the wall";
}

TEST(Car, OverlapWithAWallIsResolved) {
  Driver driver(Built(Ring()));
  driver.state.position_base_m = {0.0492, 0, 0.0015};  // 0.3 mm from the outer wall's face
  driver.Coast();
  EXPECT_NEAR(NearestWall(driver.walls(), driver.state.position_base_m, 1).distance_m, driver.car().radius_m, 1e-9);
  EXPECT_EQ(driver.state.hits, 0U);
}

// A wedge of 20 degrees: driven into it at any speed the car stops and does not come out of the other side.
TEST(Car, WedgeStopsTheCar) {
  SceneInput input = SceneOf(Block(1, {0.03, 0.001, 0.002}));
  const double half = std::numbers::pi / 18;
  for (const double side : {-1.0, 1.0}) {
    InputObject wall = Block(1, {0.03, 0.0005, 0.002});
    for (Vec3& p : wall.vertices_base_m) {
      const double x = p.x - 0.03, y = p.y;
      p = {x * std::cos(half) - side * y * std::sin(half), side * x * std::sin(half) + y * std::cos(half), p.z};
    }
    wall.car_wall = true;
    input.objects.push_back(wall);
  }
  input.vehicle.emplace().start_base_m = {-0.04, 0, 0.001};
  for (const double speed_m_s : {0.02, 0.5, 20.0, 900.0}) {
    Driver driver(Built(input));
    driver.state.velocity_base_m_s = {speed_m_s, 0.1 * speed_m_s, 0};
    for (int k = 0; k < 3000; ++k) {
      driver.Coast();
      ASSERT_LT(driver.state.position_base_m.x, -0.005);
    }
    EXPECT_LT(driver.Speed(), 1e-9) << speed_m_s;
    EXPECT_GT(NearestWall(driver.walls(), driver.state.position_base_m, 1).distance_m,
              driver.car().radius_m * (1 - 1e-6));
  }
}

TEST(Hits, AddAPulseToThePenForce) {
  Pen pen(Built(Ring()));
  pen.MoveTo({0, 0, 0.03});
  pen.Slide({0, 0, 0.03}, {0, 0.015, 0.03}, 50);
  double strongest_N = 0;
  for (int k = 0; k < 1500; ++k) {
    pen.Rest(1);
    if (pen.state.vehicle.hits > 0) strongest_N = std::max(strongest_N, Norm(pen.output.force_base_N));
  }
  EXPECT_GE(pen.output.vehicle.hits, 1U);
  EXPECT_GT(strongest_N, 0.9) << "spring 0.81 N and the pulse";
}

TEST(Hits, StrongHitIsRenderedDuringAWeakOne) {
  Driver driver(Built(Ring()));
  const base::ForceLimit limit = test::UsualLimit();
  const PulseLimits limits{limit, {}, 850};
  Impacts weak, strong;
  weak.count = strong.count = 1;
  weak.of[0] = {0.01, {1, 0, 0}, 0};
  strong.of[0] = {1, {0, 1, 0}, 0};
  StartPulses(driver.car(), limits, weak, driver.state);
  for (int k = 0; k < 15; ++k) AdvancePulses(driver.car(), limits, 1e-3, driver.state);
  StartPulses(driver.car(), limits, strong, driver.state);
  Vec3 peak;
  for (int k = 0; k < 60; ++k) {
    const PulseForce pulse = AdvancePulses(driver.car(), limits, 1e-3, driver.state);
    if (Norm(pulse.force_N) > Norm(peak)) peak = pulse.force_N;
  }
  EXPECT_NEAR(peak.y, driver.car().hit_force_N, 1e-3);
  for (const HitPulse& pulse : driver.state.pulses) EXPECT_LT(pulse.time_s, 0) << "all have ended";
  for (int k = 0; k < 20; ++k) StartPulses(driver.car(), limits, strong, driver.state);
  for (int k = 0; k < 40; ++k) {
    EXPECT_LE(Norm(AdvancePulses(driver.car(), limits, 1e-3, driver.state).force_N), 2 * (1 + 1e-12));
  }
}

// Through Step: as in the paper, a hit pushes the pen to the base, the harder the faster the car was.
TEST(Hits, PushToTheBaseByTheShareOfTheTag) {
  for (const double share : {0.0, 0.5, 1.0}) {
    double last_N = 0;
    for (const double speed_m_s : {0.02, 0.04, 0.08}) {
      SceneInput input = Ring();
      input.vehicle->hit_to_base = share;
      input.vehicle->engine_force_N = input.vehicle->road_force_N = 0;
      Pen pen(Built(input));
      const Vec3 tip = input.joystick->centre_base_m + Vec3{0.0005, -0.0005, 0};  // within the dead zone
      pen.MoveTo(tip);
      pen.Rest(3);
      pen.state.vehicle.heading_rad = 0;  // straight at the outer wall, near it
      pen.state.vehicle.position_base_m.x = 0.046;
      pen.state.vehicle.velocity_base_m_s = {speed_m_s, 0, 0};
      Vec3 peak_N;
      for (int k = 0; k < 1000; ++k) {
        pen.Rest(1);
        if (Norm(pen.output.force_base_N) > Norm(peak_N)) peak_N = pen.output.force_base_N;
      }
      ASSERT_EQ(pen.state.vehicle.hits, 1U);
      const double down_N = -Dot(peak_N, tip) / Norm(tip), off_wall_N = -peak_N.x;
      EXPECT_GT(Norm(peak_N), last_N) << share;
      last_N = Norm(peak_N);
      if (share == 0) {
        EXPECT_NEAR(peak_N.z, 0, 1e-9);
      } else if (share == 1) {
        EXPECT_NEAR(down_N, Norm(peak_N), 1e-9 * down_N);
      } else {
        EXPECT_GT(std::min(down_N, off_wall_N), 0.6 * Norm(peak_N));
      }
    }
  }
}

TEST(Road, ForceStaysWithinItsBound) {
  VehicleInput car;
  car.engine_force_N = car.road_force_N = 0.1;
  VehicleState state;
  EXPECT_EQ(RoadForce_N(car, 1e-3, state), 0) << "at rest";
  double largest_N = 0;
  for (int k = 0; k < 5000; ++k) {
    state.velocity_base_m_s = {car.speed_max_m_s * k / 5000, 0, 0};
    largest_N = std::max(largest_N, std::abs(RoadForce_N(car, 1e-3, state)));
  }
  EXPECT_LE(largest_N, kRoadForceMax_N);
  EXPECT_GT(largest_N, 0.09);
  // A road too fine for the coils is not rendered at all.
  car.engine_force_N = 0;
  car.road_wavelength_m = 1e-4;
  state.velocity_base_m_s = {0.05, 0, 0};
  for (int k = 0; k < 100; ++k) EXPECT_EQ(RoadForce_N(car, 1e-3, state), 0);
}

TEST(Build, ReportsTrackErrors) {
  SceneInput input = RingWithCheckpoints();
  input.vehicle->start_base_m.x = 0.049;
  input.vehicle->checkpoints[1].position_base_m = {-0.05, 0, 0};
  BuildReport report;
  ASSERT_TRUE(BuildScene(input, report).ok());
  std::string all;
  for (const std::string& line : report.lines) all += line + "\n";
  EXPECT_NE(all.find("vehicle: starts"), std::string::npos) << all;
  EXPECT_NE(all.find("checkpoint 1: its middle"), std::string::npos) << all;
  EXPECT_NE(all.find("512 wall segments"), std::string::npos) << all;
  input.vehicle->start_base_m.z = 0.5;
  ASSERT_TRUE(BuildScene(input, report).ok());
  all.clear();
  for (const std::string& line : report.lines) all += line + "\n";
  EXPECT_NE(all.find("no car wall at its height"), std::string::npos) << all;
  for (const auto& spoil :
       {+[](VehicleInput& v) { v.grip_g = 0; }, +[](VehicleInput& v) { v.front_share = 1; },
        +[](VehicleInput& v) { v.checkpoint_count = 17; }, +[](VehicleInput& v) { v.inertia = std::nan(""); },
        +[](VehicleInput& v) { v.checkpoints[2].width_m = -1; }}) {
    SceneInput spoilt = RingWithCheckpoints();
    spoil(*spoilt.vehicle);
    EXPECT_FALSE(BuildScene(spoilt, report).ok());
  }
}

}  // namespace test_vehicle_scenario
}  // namespace omni::haptics
