// Closed-form fits against truth, where textbooks go wrong (reflections, weights), and the joint fit against them.
#include <gtest/gtest.h>

#include "service/alignment/fit.h"
#include "tests/alignment/closed_form.h"
#include "tests/support/rig/alignment_scenario.h"

namespace omni::alignment {
namespace test_alignment_kabsch {

std::vector<PointPair> Pairs(test::AlignmentScenario& scenario, const Rigid& X_LB, int count) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    const base::Vec3 p = scenario.PointOfBase();
    pairs.push_back({.base_m = p, .space_m = TransformPoint(X_LB, p), .weight = scenario.Uniform(0.1, 3)});
  }
  return pairs;
}

TEST(AlignmentKabsch, SixDofFindsAnyBasePose) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    test::AlignmentScenario scenario(seed);
    const Rigid truth = scenario.AnyBase();
    const Rigid found = FitSixDof(Pairs(scenario, truth, 3 + static_cast<int>(seed % 5)));
    EXPECT_LT(Angle_rad(found, truth), 1e-7) << seed;
    EXPECT_LT(Distance_m(found, truth, kWorkingPoint_base_m), 1e-9) << seed;
  }
}

TEST(AlignmentKabsch, FourDofFindsLevelBasePosesFromTwoPoints) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    test::AlignmentScenario scenario(seed);
    const Rigid truth = scenario.LevelBase();
    const Rigid found = FitFourDof(Pairs(scenario, truth, 2));
    EXPECT_LT(Angle_rad(found, truth), 1e-6) << seed;
    EXPECT_LT(Distance_m(found, truth, kWorkingPoint_base_m), 1e-8) << seed;
  }
}

// Points in a plane, mirrored by noise: without the guard the determinant is -1.
TEST(AlignmentKabsch, SixDofNeverReturnsAReflection) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    test::AlignmentScenario scenario(seed);
    std::vector<PointPair> pairs = Pairs(scenario, scenario.AnyBase(), 4);
    for (PointPair& pair : pairs) pair.space_m = {-pair.space_m.x, pair.space_m.y, pair.space_m.z};
    const Eigen::Quaterniond q = base::ToEigen(FitSixDof(pairs).orientation);
    EXPECT_NEAR(q.norm(), 1, 1e-12);
    EXPECT_NEAR(q.toRotationMatrix().determinant(), 1, 1e-9) << seed;
  }
}

TEST(AlignmentKabsch, HeavierPointsHaveMoreInfluence) {
  test::AlignmentScenario scenario(4);
  const Rigid truth = scenario.AnyBase();
  std::vector<PointPair> pairs = Pairs(scenario, truth, 6);
  pairs[0].space_m.x += 0.01;
  pairs[0].weight = 1e-6;
  EXPECT_LT(Distance_m(FitSixDof(pairs), truth, {}), 1e-6);
  pairs[0].weight = 1e6;
  EXPECT_GT(Distance_m(FitSixDof(pairs), truth, {}), 3e-3);
}

// The level fit is the best yaw: turning it either way makes the residual larger.
TEST(AlignmentKabsch, FourDofMinimisesTheYawResidual) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    test::AlignmentScenario scenario(seed);
    std::vector<PointPair> pairs = Pairs(scenario, scenario.LevelBase(), 5);
    for (PointPair& pair : pairs) {
      const Eigen::Vector3d noisy = base::ToEigen(pair.space_m) + scenario.Normal(3e-3);
      pair.space_m = base::FromEigen(noisy);
    }
    const Rigid found = FitFourDof(pairs);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double weight = 0;
    for (const PointPair& pair : pairs) mean += pair.weight * base::ToEigen(pair.space_m), weight += pair.weight;
    mean /= weight;
    const auto cost = [&](double yaw) {
      // About the centroid, where yaw and place do not mix.
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()));
      double sum = 0;
      for (const PointPair& pair : pairs) {
        const Eigen::Vector3d p = base::ToEigen(TransformPoint(found, pair.base_m));
        sum += pair.weight * (mean + turn * (p - mean) - base::ToEigen(pair.space_m)).squaredNorm();
      }
      return sum;
    };
    EXPECT_LT(cost(0), cost(1e-3));
    EXPECT_LT(cost(0), cost(-1e-3));
  }
}

// A tip that is known and weights that are equal leave the joint fit nothing but these point sets.
TEST(AlignmentKabsch, JointFitOfAKnownTipIsTheClosedForm) {
  constexpr base::Vec3 kTip{0.01, -0.02, -0.1};
  for (unsigned seed = 0; seed < 40; ++seed) {
    test::AlignmentScenario scenario(seed);
    const Rigid truth = scenario.AnyBase();
    std::vector<Sample> samples;
    std::vector<PointPair> pairs;
    for (int i = 0; i < 12; ++i) {
      samples.push_back(scenario.At(truth, scenario.PointOfBase(), kTip, 2e-3, i));
      pairs.push_back(
          {.base_m = samples.back().point_base_m, .space_m = TransformPoint(samples.back().controller_space, kTip)});
    }
    Prior prior;
    prior.level = false;
    prior.robust = false;
    prior.tip_controller_m = kTip;
    prior.tip_sigma_m = 1e-8;
    const auto outcome = FitBasePose(samples, prior, {});
    ASSERT_TRUE(outcome.ok()) << seed << ": " << outcome.error();
    const Rigid closed = FitSixDof(pairs);
    EXPECT_GT(Distance_m(closed, truth, kWorkingPoint_base_m), 1e-4) << seed;
    EXPECT_LT(Distance_m(outcome->base_space, closed, kWorkingPoint_base_m), 1e-6) << seed;
    EXPECT_LT(Angle_rad(outcome->base_space, closed), 1e-5) << seed;
  }
}

}  // namespace test_alignment_kabsch
}  // namespace omni::alignment
