// Stick and slip against Coulomb's law.
#include <gtest/gtest.h>

#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_haptics_friction {

Material Rubbing(double mu_s, double mu_d) {
  Material m;
  m.stiffness_N_m = 400;
  m.static_friction = mu_s;
  m.dynamic_friction = mu_d;
  return m;
}

Pen PressedAt(const Vec3& tip, const Material& material, int n = 8) {
  Pen pen(Built(SceneOf(Block(n, {0.02, 0.02, 0.02}), material)));
  pen.Slide({tip.x, tip.y, 0.022}, tip, 100);
  return pen;
}

double Tangential(const Pen& pen) { return std::hypot(pen.output.force_base_N.x, pen.output.force_base_N.y); }

// Pressed 1 mm deep: F_n = 0.4 N. The cone at mu_s = 0.5 is left after 0.5 mm.
TEST(Friction, SticksWithinStaticConeAndSlipsOnDynamicCone) {
  Pen pen = PressedAt({0, 0, 0.019}, Rubbing(0.5, 0.3));
  pen.Slide({0, 0, 0.019}, {0.00049, 0, 0.019}, 50);
  EXPECT_TRUE(pen.state.contacts[0].sticking);
  EXPECT_NEAR(pen.output.force_base_N.x, -400 * 0.00049, 1e-9);
  pen.Slide({0.00049, 0, 0.019}, {0.00052, 0, 0.019}, 10);
  EXPECT_FALSE(pen.state.contacts[0].sticking);
  pen.Slide({0.00052, 0, 0.019}, {0.006, 0, 0.019}, 200);
  EXPECT_FALSE(pen.state.contacts[0].sticking);
  EXPECT_NEAR(pen.output.force_base_N.x, -0.3 * 0.4, 1e-9);
  EXPECT_NEAR(pen.output.contacts[0].tangential_force_N, 0.12, 1e-9);
  pen.Rest(2);
  EXPECT_TRUE(pen.state.contacts[0].sticking) << "a tip at rest sticks";
  EXPECT_NEAR(pen.output.force_base_N.x, -0.12, 1e-9);
}

TEST(Friction, ReversalSticksFirst) {
  Pen pen = PressedAt({0, 0, 0.019}, Rubbing(0.5, 0.3));
  pen.Slide({0, 0, 0.019}, {0.005, 0, 0.019}, 200);
  pen.Slide({0.005, 0, 0.019}, {0.0048, 0, 0.019}, 20);
  EXPECT_TRUE(pen.state.contacts[0].sticking);
  EXPECT_NEAR(pen.output.force_base_N.x, -0.12 + 400 * 0.0002, 1e-9);
}

TEST(Friction, DoesNotDriftWhileSticking) {
  Pen pen = PressedAt({0, 0, 0.019}, Rubbing(0.5, 0.4));
  const std::uint32_t triangle = pen.state.contacts[0].anchor_triangle;
  const auto weights = pen.state.contacts[0].anchor_weights;
  Random random(11);
  for (int k = 0; k < 100'000; ++k) {
    const double depth_m = 0.001 + random.Uniform(0, 0.0005);
    const double r = random.Uniform(0, 0.49) * depth_m, angle = random.Uniform(0, 6.28);
    pen.MoveTo({r * std::cos(angle), r * std::sin(angle), 0.02 - depth_m});
    ASSERT_TRUE(pen.state.contacts[0].sticking);
  }
  EXPECT_EQ(pen.state.contacts[0].anchor_triangle, triangle);
  EXPECT_EQ(pen.state.contacts[0].anchor_weights, weights);
  pen.MoveTo({0, 0, 0.019});
  pen.Rest(5);
  EXPECT_LT(Tangential(pen), 1e-12);
}

TEST(Friction, DoesNotDependOnTriangleSize) {
  for (const int n : {1, 5, 40}) {
    Pen pen = PressedAt({-0.01, 0.0003, 0.019}, Rubbing(0.6, 0.35), n);
    pen.Slide({-0.01, 0.0003, 0.019}, {0.01, 0.0103, 0.019}, 500);
    EXPECT_NEAR(Tangential(pen), 0.35 * 0.4, 1e-9) << n;
    EXPECT_NEAR(pen.output.force_base_N.z, 0.4, 1e-9) << n;
  }
}

TEST(Friction, FrictionlessMeansNoTangentialForce) {
  Pen pen = PressedAt({0, 0, 0.019}, Rubbing(0, 0));
  pen.Slide({0, 0, 0.019}, {0.01, 0, 0.019}, 100);
  EXPECT_LT(Tangential(pen), 1e-12);
}

}  // namespace test_haptics_friction
}  // namespace omni::haptics
