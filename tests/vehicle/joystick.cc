// The stick's notches: a potential, within the stiffness bound, without steps.
#include <gtest/gtest.h>

#include "service/haptics/stability/stability.h"
#include "tests/vehicle/scene.h"

namespace omni::haptics {
namespace test_vehicle_joystick {

JoystickInput RandomStick(Random& random) {
  JoystickInput stick;
  stick.range_m = random.Uniform(0.004, 0.03);
  stick.dead_zone_m = random.Uniform(0, 0.4) * stick.range_m;
  stick.stiffness_N_m = random.Uniform(0, 80);
  stick.damping_Ns_m = 0;
  stick.detent_force_N = random.Uniform(0.01, 0.3);
  stick.radial_detents = static_cast<int>(random.Next() % 9);
  stick.angular_detents = static_cast<int>(random.Next() % 17);
  return stick;
}

// Round a random closed polygon the notches do no work.
TEST(Detents, DoNoWorkAroundClosedPaths) {
  Random random(1);
  for (int m = 0; m < 40; ++m) {
    const JoystickInput stick = RandomStick(random);
    Vec3 corner[3];
    for (Vec3& c : corner) c = random.InBox(stick.range_m);
    double work_J = 0, size_J = 0;
    constexpr int kSteps = 20'000;
    for (int k = 0; k < 3; ++k) {
      const Vec3 way = (1.0 / kSteps) * (corner[(k + 1) % 3] - corner[k]);
      for (int i = 0; i < kSteps; ++i) {
        const Vec3 at = corner[k] + (i + 0.5) * way;
        const double piece_J = Dot(DetentForce(stick, {at.x, at.y, 0}), {way.x, way.y, 0});
        work_J += piece_J;
        size_J += std::abs(piece_J);
      }
    }
    EXPECT_LE(std::abs(work_J), 1e-4 * size_J) << m;
  }
}

// Between any two near places the force changes by no more than the limit times their distance.
TEST(Detents, StayWithinTheStiffnessLimitWithTheSpring) {
  Random random(2);
  for (int m = 0; m < 60; ++m) {
    const JoystickInput stick = RandomStick(random);
    const double curvature_N_m = DetentCurvature_N_m(stick);
    Input input;
    const double limit_N_m = 110;
    const StiffnessBound bound{limit_N_m, 1, {}};
    for (int k = 0; k < 3000; ++k) {
      const Vec3 u = random.InBox(1.3 * stick.range_m), step = random.InBox(1e-6 * stick.range_m);
      Input moved = input;
      input.device_point_base_m = {u.x, u.y, 0};
      moved.device_point_base_m = {u.x + step.x, u.y + step.y, 0};
      const Vec3 change =
          JoystickForce(stick, curvature_N_m, bound, moved) - JoystickForce(stick, curvature_N_m, bound, input);
      const double distance_m = std::hypot(step.x, step.y);
      ASSERT_LE(Norm(change), 1.03 * limit_N_m * distance_m + 1e-12) << m;
    }
  }
}

TEST(Detents, HoldTheStickInTheirNotches) {
  JoystickInput stick;
  stick.radial_detents = 3;
  stick.angular_detents = 4;
  const double travel_m = stick.range_m - stick.dead_zone_m;
  for (int k = 1; k < 3; ++k) {
    const double r = stick.dead_zone_m + travel_m * k / 3;
    EXPECT_LT(Norm(DetentForce(stick, {0, r, 0})), 1e-12) << "at rest in a notch";
    EXPECT_LT(DetentForce(stick, {0, r + 0.1 * travel_m, 0}).y, -1e-3) << "drawn back";
    EXPECT_GT(DetentForce(stick, {0, r - 0.1 * travel_m, 0}).y, 1e-3);
    EXPECT_LT(DetentForce(stick, {0.1 * r, r, 0}).x, -1e-4) << "drawn to straight ahead";
    EXPECT_GT(DetentForce(stick, {-0.1 * r, r, 0}).x, 1e-4);
  }
  EXPECT_EQ(DetentForce(stick, {0, 0.5 * stick.dead_zone_m, 0}), Vec3{});
  stick.detent_force_N = 0;
  EXPECT_EQ(DetentCurvature_N_m(stick), 0);
}

// The spring sets in without a kink and is what it was beyond.
TEST(Detents, DeadZoneHasASmoothEdge) {
  JoystickInput stick;
  stick.damping_Ns_m = 0;
  const auto at = [&](double x) {
    Input input;
    input.device_point_base_m = {x, 0, 0};
    return -JoystickForce(stick, 0, StiffnessBound{.stiffness_N_m = 110, .damping_Ns_m = 1}, input).x;
  };
  EXPECT_EQ(at(0.8 * stick.dead_zone_m), 0);
  EXPECT_NEAR(at(2 * stick.dead_zone_m), 60 * stick.dead_zone_m, 1e-12);
  double last_slope = 0;
  constexpr double kStep = 1e-6;
  for (double x = 0; x < 2 * stick.dead_zone_m; x += kStep) {
    const double slope = (at(x + kStep) - at(x)) / kStep;
    ASSERT_GE(slope, last_slope - 1e-6);
    ASSERT_LE(slope - last_slope, 60 * kStep / (0.3 * stick.dead_zone_m) * 1.01 + 1e-6) << "no step in the slope";
    last_slope = slope;
  }
}

}  // namespace test_vehicle_joystick
}  // namespace omni::haptics
