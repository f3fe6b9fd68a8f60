// Constraints over random shapes, places and motions: they give no energy, stay within max_force, and never jump.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "service/base/eigen.h"
#include "service/base/vec.h"
#include "service/haptics/applied/constraint.h"

namespace omni::haptics {

using base::Vec3;
namespace test_haptics_constraints {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 Vector(double size) { return {In(-size, size), In(-size, size), In(-size, size)}; }
  Vec3 Direction() {
    for (;;) {
      const Vec3 v = Vector(1);
      if (Norm(v) > 0.1 && Norm(v) < 1) return Normalized(v);
    }
  }
  Constraint Shape() {
    Constraint c;
    c.kind = static_cast<ConstraintKind>(1 + random_() % kConstraintKinds);
    c.side = static_cast<ConstraintSide>(random_() % 3);
    c.stiffness_N_m = c.kind == ConstraintKind::kViscous ? 0 : In(10, 2000);
    c.damping_Ns_m = In(0, 3);
    c.max_force_N = In(0.1, 5);
    c.radius_m = c.kind == ConstraintKind::kSphere ? In(0.005, 0.05) : (random_() % 2 == 0 ? 0 : In(0, 0.01));
    c.point_base_m = Vector(0.03);
    c.direction_base = Direction();
    return c;
  }

 private:
  std::mt19937_64 random_;
};

Vec3 At(const Constraint& c, const Vec3& x, const Vec3& v) {
  return ForceOf(c, StretchOf(c, x), c.stiffness_N_m, c.damping_Ns_m, x, v);
}

// A closed path without corners, in u in [0, 1].
struct Loop {
  Vec3 centre, a, b, c;
  Vec3 Place(double u) const {
    const double t = 2 * std::numbers::pi * u;
    return centre + std::sin(t) * a + std::cos(t) * b + std::sin(2 * t) * c;
  }
};

TEST(Constraints, GiveNoEnergyAroundClosedPaths) {
  Dice dice(1);
  for (int run = 0; run < 300; ++run) {
    const Constraint c = dice.Shape();
    const Loop loop{dice.Vector(0.03), dice.Vector(0.02), dice.Vector(0.02), dice.Vector(0.01)};
    const double seconds = dice.In(0.2, 5);
    constexpr int kSteps = 4000;
    double given_J = 0;
    double moved_J = 0;
    for (int i = 0; i < kSteps; ++i) {
      const Vec3 dx = loop.Place((i + 1.0) / kSteps) - loop.Place(static_cast<double>(i) / kSteps);
      const Vec3 force_N = At(c, loop.Place((i + 0.5) / kSteps), (kSteps / seconds) * dx);
      given_J += Dot(force_N, dx);
      moved_J += Norm(force_N) * Norm(dx);
    }
    EXPECT_LE(given_J, 1e-4 * moved_J) << "run " << run << ", kind " << static_cast<int>(c.kind);
  }
}

TEST(Constraints, SpringForceIsNegativeGradientOfStoredEnergy) {
  Dice dice(2);
  int checked = 0;
  for (int run = 0; run < 4000; ++run) {
    Constraint c = dice.Shape();
    c.damping_Ns_m = 0;
    const Vec3 x = dice.Vector(0.05);
    const double h = 1e-7;
    Vec3 gradient;
    bool conservative = true;
    const auto energy_J = [&](const Vec3& at) {
      const Stretch stretch = StretchOf(c, at);
      conservative = conservative && stretch.conservative && stretch.length_m != 0;
      return StoredIn_J(c, stretch, c.stiffness_N_m);
    };
    const auto slope = [&](const Vec3& step) { return (energy_J(x + step) - energy_J(x - step)) / (2 * h); };
    gradient = {slope({h, 0, 0}), slope({0, h, 0}), slope({0, 0, h})};
    if (!conservative) continue;
    ++checked;
    const Vec3 force_N = At(c, x, {});
    EXPECT_LE(Norm(force_N + gradient), 1e-4 * Norm(force_N) + 1e-7) << "kind " << static_cast<int>(c.kind);
  }
  EXPECT_GT(checked, 1500);
}

TEST(Constraints, OneSidedConstraintsNeverPull) {
  Dice dice(3);
  for (int run = 0; run < 20000; ++run) {
    const Constraint c = dice.Shape();
    const Vec3 x = dice.Vector(0.06);
    const Stretch stretch = StretchOf(c, x);
    if (!stretch.one_sided) continue;
    const Vec3 force_N = At(c, x, dice.Vector(2));
    EXPECT_LE(Dot(force_N, stretch.outward), 1e-12);
    EXPECT_TRUE(stretch.length_m > 0 || Norm(force_N) == 0);
  }
}

TEST(Constraints, StayWithinMaxForceForAnyInput) {
  Dice dice(4);
  const double nasty[] = {
      0, 1e-300, 1e300, -1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()};
  for (int run = 0; run < 20000; ++run) {
    Constraint c = dice.Shape();
    const auto wild = [&](double sane) { return dice.In(0, 1) < 0.15 ? nasty[run % 6] : sane; };
    c.point_base_m.x = wild(c.point_base_m.x);
    c.velocity_base_m_s.y = wild(0);
    c.angular_velocity_base_rad_s.z = wild(0);
    c.stiffness_N_m = wild(c.stiffness_N_m);
    c.radius_m = wild(c.radius_m);
    const Vec3 x = dice.Vector(0.06);
    const Constraint moved = MovedConstraint(c, wild(0.01));
    const Vec3 force_N = At(moved, x, {wild(0.1), 0, 0});
    ASSERT_TRUE(IsWithin(force_N, c.max_force_N * (1 + 1e-9))) << "run " << run;
  }
}

// The place on the shape that is nearest to x.
Vec3 OnShape(const Constraint& c, const Vec3& x) {
  Constraint held = c;
  held.side = ConstraintSide::kOn;
  if (c.kind == ConstraintKind::kLine) held.radius_m = 0;
  const Stretch stretch = StretchOf(held, x);
  const double beyond_m = c.kind == ConstraintKind::kLine ? stretch.length_m - c.radius_m : stretch.length_m;
  return x - beyond_m * stretch.outward;
}

Eigen::Matrix3d MatrixOf(const std::function<Vec3(const Vec3&)>& linear) {
  Eigen::Matrix3d M;
  M << base::ToEigen(linear({1, 0, 0})), base::ToEigen(linear({0, 1, 0})), base::ToEigen(linear({0, 0, 1}));
  return M;
}

Eigen::Matrix3d Projection(const Subspace& on) {
  return MatrixOf([&](const Vec3& v) { return Project(on, v); });
}

// Slightly beyond a shape that is not much curved: dF/dx = -K P, dF/dv = -b P, P the projection on `stiff`. Of one that
// only pushes, b still fades in.
TEST(Constraints, StiffSubspaceIsWhereForcesChange) {
  Dice dice(7);
  std::array<int, kConstraintKinds + 1> checked{};
  for (int run = 0; run < 6000; ++run) {
    Constraint c = dice.Shape();
    c.max_force_N = 100;
    if (c.radius_m > 0) c.radius_m = dice.In(0.02, 0.05);
    const Vec3 x = OnShape(c, dice.Vector(0.06)) + 4e-4 * dice.Direction();
    const Stretch stretch = StretchOf(c, x);
    const bool viscous = c.stiffness_N_m == 0;
    if (!viscous && stretch.length_m < 5e-5) continue;
    const Eigen::Matrix3d P = Projection(stretch.stiff);
    const Eigen::Matrix3d of_place = MatrixOf([&](const Vec3& e) {
      constexpr double kStep_m = 1e-6;
      return (0.5 / kStep_m) * (At(c, x + kStep_m * e, {}) - At(c, x - kStep_m * e, {}));
    });
    EXPECT_LE((of_place + c.stiffness_N_m * P).norm(), 0.05 * c.stiffness_N_m) << "kind " << static_cast<int>(c.kind);
    const Eigen::Matrix3d of_velocity = MatrixOf([&](const Vec3& v) { return At(c, x, 1e-3 * v) - At(c, x, {}); });
    const double damping = stretch.one_sided ? of_velocity.norm() : 1e-3 * c.damping_Ns_m;
    EXPECT_LE((of_velocity + damping * P).norm(), 1e-9 + 1e-6 * damping) << "kind " << static_cast<int>(c.kind);
    EXPECT_LE(of_velocity.norm(), 1e-3 * c.damping_Ns_m * std::sqrt(3.0) * (1 + 1e-9));
    ++checked[static_cast<std::size_t>(c.kind)];
  }
  for (std::uint32_t kind = 1; kind <= kConstraintKinds; ++kind) EXPECT_GT(checked[kind], 100) << "kind " << kind;
}

TEST(Constraints, OverlapIsTheNormOfTheProductOfProjections) {
  Dice dice(8);
  for (int run = 0; run < 2000; ++run) {
    const auto any = [&] {
      const Constraint c = dice.Shape();
      return StretchOf(c, dice.Vector(0.05)).stiff;
    };
    const Subspace a = any(), b = any();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(Projection(a) * Projection(b));
    EXPECT_NEAR(Overlap(a, b), svd.singularValues()[0], 1e-6);
    EXPECT_EQ(Overlap(a, b), Overlap(b, a));
  }
}

// |F(x + h) - F(x)| <= L |h| everywhere: also where a shape has no direction, and where it is just met.
TEST(Constraints, ForceIsLipschitzContinuous) {
  Dice dice(5);
  for (int run = 0; run < 20000; ++run) {
    const Constraint c = dice.Shape();
    Vec3 x = dice.Vector(0.06);
    if (run % 3 == 0) x = c.point_base_m + dice.Vector(1e-4);  // where spheres and tubes have no direction
    if (run % 3 == 1) x = OnShape(c, x) + dice.Vector(5e-7);   // where it is just met
    const Vec3 step = dice.Vector(1e-6);
    const Vec3 v = dice.Vector(0.3);
    const double radius_m = std::max(c.radius_m, 1e-3);
    // Spring, damper that grows in over half a millimetre, and a direction that turns with 1 / r at the centre.
    const double slope_N_m = 4 * c.stiffness_N_m + c.damping_Ns_m * Norm(v) * (2 / 5e-4 + 8 / radius_m);
    EXPECT_LE(Norm(At(c, x + step, v) - At(c, x, v)), slope_N_m * Norm(step) + 1e-12)
        << "run " << run << ", kind " << static_cast<int>(c.kind);
  }
}

TEST(Constraints, MoveWithTheirFrame) {
  Dice dice(6);
  for (int run = 0; run < 500; ++run) {
    Constraint c = dice.Shape();
    c.velocity_base_m_s = dice.Vector(0.2);
    const Constraint later = MovedConstraint(c, 0.02);
    EXPECT_LE(Norm(later.point_base_m - c.point_base_m - 0.02 * c.velocity_base_m_s), 1e-15);
    // On a point that moves with the frame only the spring acts.
    const Vec3 x = dice.Vector(0.05);
    Constraint springs = c;
    springs.damping_Ns_m = 0;
    EXPECT_LE(Norm(At(c, x, c.velocity_base_m_s) - At(springs, x, c.velocity_base_m_s)), 1e-12);
    EXPECT_EQ(MovedConstraint(c, 10).velocity_base_m_s, Vec3{}) << "without updates it stands still";
  }
}

}  // namespace test_haptics_constraints
}  // namespace omni::haptics
