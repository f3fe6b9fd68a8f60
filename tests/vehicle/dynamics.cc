// The bicycle: against its closed-form steady state, at the limit of grip, down to rest.
#include <gtest/gtest.h>

#include "tests/vehicle/scene.h"

namespace omni::haptics {
namespace test_vehicle_dynamics {

VehicleInput Car() {
  VehicleInput car;
  car.start_heading_rad = 0.3;
  return car;
}

// A car that holds `speed` with the wheels at `steer` (left), until it runs steadily.
struct Steady {
  double speed_m_s, radius_m, side_g;
  bool sliding;
};
Steady DriveSteadily(const VehicleInput& car, double steer_rad, double throttle) {
  Driver driver(Plain(car));
  driver.Go({-steer_rad / car.steer_max_rad, throttle}, 6000);
  const double turn_rad_s = driver.state.yaw_rate_rad_s, speed_m_s = driver.Speed();
  return {speed_m_s, speed_m_s / turn_rad_s, speed_m_s * turn_rad_s / kGravity_m_s2, driver.state.sliding};
}

TEST(Bicycle, TyreForceIsLinearThenSaturatesAtGrip) {
  EXPECT_NEAR(BrushTyre(1e-6) / 1e-6, 1, 1e-5);
  EXPECT_NEAR(BrushTyre(3), 1, 1e-15);
  EXPECT_EQ(BrushTyre(50), 1);
  EXPECT_EQ(BrushTyre(std::nan("")), 1);
  for (double s = 0; s < 4; s += 0.01) EXPECT_LE(BrushTyre(s), BrushTyre(s + 0.01) + 1e-15);
}

// delta = L / R + (1 / C_f - 1 / C_r) a / g while slip is small [Milliken, Race Car Vehicle Dynamics, 5.4].
TEST(Bicycle, SteadyCorneringMatchesClosedForm) {
  for (const double rear : {3.0, 4.5, 9.0}) {
    VehicleInput car = Car();
    car.slip_stiffness_rear_per_rad = rear;
    car.wheelbase_m = 0.02;
    car.grip_g = 10;  // the linear part of the tyre
    for (const double steer_rad : {0.02, 0.05, 0.1}) {
      for (const double throttle : {0.2, 0.6, 1.0}) {
        car.speed_max_m_s = 0.4;
        const Steady steady = DriveSteadily(car, steer_rad, throttle);
        const double understeer = 1 / car.slip_stiffness_front_per_rad - 1 / rear;
        const double analytic_rad = car.wheelbase_m / steady.radius_m + understeer * steady.side_g;
        EXPECT_NEAR(analytic_rad / steer_rad, 1, 0.01) << rear << " " << steer_rad << " " << throttle;
      }
    }
  }
}

TEST(Bicycle, HighGripMatchesTheKinematicBicycle) {
  VehicleInput car = Car();
  car.grip_g = 10;
  car.slip_stiffness_front_per_rad = car.slip_stiffness_rear_per_rad = 100;
  const Steady steady = DriveSteadily(car, 0.3, 0.5);
  // Radius of the centre of mass: R / cos(beta), tan(beta) = b tan(delta) / L.
  const double beta = std::atan(car.front_share * std::tan(0.3));
  EXPECT_NEAR(steady.radius_m, car.wheelbase_m / std::tan(0.3) / std::cos(beta), 0.01 * steady.radius_m);
}

TEST(Bicycle, SlidesWideAtTheGripLimit) {
  VehicleInput car = Car();
  car.grip_g = 0.03;
  double last_m = 0;
  for (const double throttle : {0.4, 0.6, 0.8, 1.0}) {
    const Steady steady = DriveSteadily(car, 0.5, throttle);
    EXPECT_LT(steady.side_g, car.grip_g * 1.0001);
    EXPECT_GT(steady.radius_m, last_m) << "faster is wider";
    last_m = steady.radius_m;
  }
  EXPECT_GT(last_m, 1.5 * car.wheelbase_m / std::tan(0.5)) << "much wider than the wheels point";
  EXPECT_TRUE(DriveSteadily(car, 0.5, 1).sliding);
}

TEST(Bicycle, ReachesTheSpeedSetByThrottle) {
  Driver driver(Plain(Car()));
  driver.Go({0, 1}, 100);
  EXPECT_NEAR(driver.Speed(), 0.1 * driver.car().acceleration_m_s2, 1e-9) << "from a standstill";
  driver.Go({0, 1}, 5000);
  EXPECT_NEAR(driver.Speed(), driver.car().speed_max_m_s, 1e-6);
  driver.Go({0, 0.5}, 5000);
  EXPECT_NEAR(driver.Speed(), 0.5 * driver.car().speed_max_m_s, 1e-6);
}

TEST(Bicycle, BrakesThenReverses) {
  Driver driver(Plain(Car()));
  driver.Go({0, 1}, 3000);
  const double speed_m_s = driver.Speed();
  driver.Go({0, -1}, 100);
  EXPECT_LT(driver.Speed(), speed_m_s - 0.1 * 2 * driver.car().acceleration_m_s2);
  driver.Go({0, -1}, 5000);
  const double along = driver.state.velocity_base_m_s.x * std::cos(driver.state.heading_rad) +
                       driver.state.velocity_base_m_s.y * std::sin(driver.state.heading_rad);
  EXPECT_NEAR(along, -0.3 * driver.car().speed_max_m_s, 1e-6);
}

TEST(Bicycle, CoastsToRestAndStaysThere) {
  Driver driver(Plain(Car()));
  driver.Go({0.4, 1}, 2000);
  driver.Go({0.4, 0}, 5000);
  EXPECT_LT(driver.Speed(), 1e-12);
  EXPECT_LT(std::abs(driver.state.yaw_rate_rad_s), 1e-9);
  const VehicleState rest = driver.state;
  driver.Go({1, 0}, 1000);
  EXPECT_LT(Norm(driver.state.position_base_m - rest.position_base_m), 1e-12) << "steering does not move it";
  EXPECT_NEAR(driver.state.heading_rad, rest.heading_rad, 1e-9);
}

TEST(Bicycle, SteersRightForARightStick) {
  Driver driver(Plain(Car()));
  driver.Go({0.3, 1}, 100);
  EXPECT_LT(driver.state.heading_rad, driver.car().start_heading_rad);
}

TEST(Bicycle, SidewaysMotionStopsByFriction) {
  VehicleInput car = Car();
  car.grip_g = 0.1;
  Driver driver(Plain(car));
  driver.state.velocity_base_m_s = {-0.5 * std::sin(0.3), 0.5 * std::cos(0.3), 0};
  driver.Go({0, 0}, 100);
  EXPECT_TRUE(driver.state.sliding);
  EXPECT_NEAR(driver.Speed(), 0.5 - 0.1 * 0.1 * kGravity_m_s2, 0.005);
  driver.Go({0, 0}, 1000);
  EXPECT_LT(driver.Speed(), 1e-6);
}

}  // namespace test_vehicle_dynamics
}  // namespace omni::haptics
