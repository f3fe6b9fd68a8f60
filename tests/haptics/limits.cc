// Whatever comes in: the force is finite, within the limit, and moves no faster than the slew limit.
#include <gtest/gtest.h>

#include <limits>

#include "service/base/force_limit.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_haptics_limits {

double Odd(Random& random) {
  const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(),
                        -1e300,
                        1e30,
                        -0.0,
                        1e-310,
                        50.0};
  return odd[random.Next() % std::size(odd)];
}

SceneInput Everything() {
  Material m;
  m.stiffness_N_m = 1500;
  m.damping_Ns_m = 1;
  m.texture_amplitude_m = 2e-4;
  m.vibration_amplitude_N = 0.1;
  m.viscosity_Ns_m = 1;
  m.magnet_max_force_N = 0.5;
  m.extrude.enabled = true;
  m.extrude.grab_force_N = 0.2;
  m.extrude.dwell_s = 0.02;
  SceneInput input = SceneOf(Block(5, {0.02, 0.02, 0.02}), m);
  input.objects.push_back(Sphere(8, 0.015));
  input.objects.push_back(Periodic(30, 12, [](double u, double v) { return TorusPoint(0.025, 0.006, u, v); }));
  input.objects.back().double_sided = true;
  input.objects.back().car_wall = true;
  input.joystick.emplace();
  input.vehicle.emplace().start_base_m = {0.05, 0, 0};
  return input;
}

TEST(Limits, ForceAndSlewLimitsHoldForRandomInputs) {
  const Scene scene = Built(Everything());
  ASSERT_FALSE(scene.empty());
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    Pen pen(scene);
    pen.config.ramp_s = 0.05;
    pen.config.predict_max_s = 0.02;
    Vec3 tip, last;
    for (int k = 0; k < 2000; ++k) {
      tip = random.Next() % 100 == 0 ? random.InBox(0.03) : tip + random.InBox(random.Next() % 8 == 0 ? 0.01 : 3e-4);
      if (!(Norm(tip) < 0.05)) tip = {};
      Vec3 given = tip;
      if (random.Next() % 200 == 0) given.y = Odd(random);
      pen.input.tracked = random.Next() % 150 != 0;
      pen.input.dt_s = random.Next() % 50 == 0 ? Odd(random) : 1e-3;
      pen.input.device_point_base_m = given;
      pen.input.velocity_base_m_s = random.Next() % 40 == 0 ? Vec3{Odd(random), 0, 0} : random.InBox(1);
      pen.input.noise.position_m2 = random.Next() % 40 == 0 ? Odd(random) : random.Uniform(0, 4e-8);
      pen.input.noise.velocity_m2_s2 = random.Next() % 40 == 0 ? Odd(random) : random.Uniform(0, 1e-3);
      pen.input.delay_s = random.Next() % 40 == 0 ? Odd(random) : random.Uniform(0, 1e-3);
      pen.input.t_ns += 1'000'000;
      if (random.Next() % 500 == 0) EnterScene(scene, pen.state);
      Step(pen.config, scene, pen.input, pen.state, pen.output);
      const Vec3 force = pen.output.force_base_N;
      ASSERT_TRUE(IsWithin(force, 2)) << "seed " << seed;
      ASSERT_TRUE(base::FeasibleScale(pen.input.limit, force) >= 1 - 1e-12) << "seed " << seed;
      const double dt_s = pen.input.dt_s >= 0 ? std::min(pen.input.dt_s, 5e-3) : 0;
      ASSERT_LE(Norm(force - last), pen.config.force_slew_N_s * dt_s + 1e-12) << "seed " << seed << " tick " << k;
      last = force;
    }
  }
}

// A limit that changes at random wins over the slew limit, and keeps the direction.
TEST(Limits, ForceLimitOverridesSlewLimitAndKeepsDirection) {
  Material m;
  m.static_friction = m.dynamic_friction = 0;
  Pen pen(Built(SceneOf(Block(3, {0.02, 0.02, 0.02}), m)));
  pen.Slide({0, 0, 0.021}, {0, 0, 0.016}, 100);
  EXPECT_NEAR(pen.output.force_base_N.z, 1.6, 1e-9);
  Random random(4);
  for (int k = 0; k < 2000; ++k) {
    pen.input.limit.force_max_N = random.Uniform(0, 3);
    for (double& a : pen.input.limit.current_max_A) a = random.Uniform(0, 15);
    for (double& a : pen.input.limit.ampere_per_newton) a = random.Uniform(-8, 8);
    for (double& a : pen.input.limit.bias_A) a = random.Uniform(-3, 3);
    pen.Rest(1);
    const Vec3 force = pen.output.force_base_N;
    ASSERT_TRUE(Norm(force) == 0 || base::FeasibleScale(pen.input.limit, force) >= 1 - 1e-12);
    ASSERT_LT(std::hypot(force.x, force.y), 1e-12) << "direction kept";
    ASSERT_GE(force.z, 0);
    if (force.z < 1.6 * (1 - 1e-9)) continue;
    EXPECT_FALSE(pen.output.saturated);
  }
}

}  // namespace test_haptics_limits
}  // namespace omni::haptics
