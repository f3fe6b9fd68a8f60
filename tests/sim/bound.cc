// The Cramer-Rao bound: known figures, and its order when less is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/rig/bound.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace test_sim_bound {

Rig Ideal() { return Rig(support::NominalDevice(), {.sizes = NoImperfections(), .noise = NoiseMode::kUltraHigh}); }

BoundOptions Quiet() {
  BoundOptions options;
  options.noise_T = NoiseOf_T(NoiseMode::kUltraHigh);
  return options;
}

const MagnetPose kPose{{0.01, -0.02, 0.065}, base::Normalized({0.2, 0.3, -1})};

// The figure known for this geometry: a median of .114 mm and .099 deg over all reachable poses.
TEST(SimBound, MedianBoundOfRandomPosesMatchesKnownFigures) {
  Rig rig = Ideal();
  Random random(91);
  std::vector<double> position_mm;
  std::vector<double> orientation_deg;
  for (int i = 0; i < 400; ++i) {
    const MagnetPose pose = rig.DrawPose({}, random);
    const auto bound = CramerRao(rig, pose, Quiet());
    ASSERT_TRUE(bound.has_value());
    position_mm.push_back(1e3 * std::sqrt(bound->position_m2));
    orientation_deg.push_back(57.29578 * std::sqrt(bound->orientation_rad2));
  }
  std::sort(position_mm.begin(), position_mm.end());
  std::sort(orientation_deg.begin(), orientation_deg.end());
  EXPECT_NEAR(position_mm[200], 0.114, 0.02);
  EXPECT_NEAR(orientation_deg[200], 0.099, 0.02);
}

TEST(SimBound, GrowsWithNoiseAndWithUnknownParameters) {
  Rig rig = Ideal();
  const auto known = CramerRao(rig, kPose, Quiet());
  BoundOptions options = Quiet();
  for (double& noise_T : options.noise_T) noise_T *= 2;
  EXPECT_NEAR(CramerRao(rig, kPose, options)->position_m2 / known->position_m2, 4, 1e-6);

  const auto with = [&](double current_A, double ambient_T, double moment) {
    BoundOptions less = Quiet();
    less.current_prior_A = current_A;
    less.ambient_prior_T = ambient_T;
    less.moment_prior = moment;
    return CramerRao(rig, kPose, less)->position_m2;
  };
  EXPECT_NEAR(with(1e-9, 1e-15, 1e-9), known->position_m2, 1e-4 * known->position_m2);
  EXPECT_GT(with(8e-3, 0, 0), known->position_m2);
  EXPECT_GT(with(BoundOptions::kUnknown, 0, 0), with(8e-3, 0, 0));
  EXPECT_GT(with(0, BoundOptions::kUnknown, 0), known->position_m2);
  EXPECT_GT(with(0, 0, BoundOptions::kUnknown), known->position_m2);
  EXPECT_GT(with(BoundOptions::kUnknown, BoundOptions::kUnknown, 0), with(BoundOptions::kUnknown, 0, 0));
}

TEST(SimBound, TracesMatchTheCovariance) {
  Rig rig = Ideal();
  const auto bound = CramerRao(rig, kPose, Quiet());
  double position = 0;
  double orientation = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    (i < 3 ? position : orientation) += bound->covariance[6 * i];
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_NEAR(bound->covariance[5 * i + j], bound->covariance[5 * j + i],
                  1e-9 * std::sqrt(bound->covariance[6 * i] * bound->covariance[6 * j]));
    }
  }
  EXPECT_EQ(position, bound->position_m2);
  EXPECT_EQ(orientation, bound->orientation_rad2);
  EXPECT_NEAR(Dot(bound->tangent_base[0], kPose.axis_base), 0, 1e-15);
  EXPECT_NEAR(Dot(bound->tangent_base[0], bound->tangent_base[1]), 0, 1e-15);
}

TEST(SimBound, SaturatedAxesCarryNoInformation) {
  base::DeviceGeometry device = support::NominalDevice();
  device.sensor_range_T = 1e-4;
  Rig rig(device, {.sizes = NoImperfections()});
  BoundOptions options = Quiet();
  const auto clipped = CramerRao(rig, kPose, options);
  options.saturation = false;
  const auto free = CramerRao(rig, kPose, options);
  ASSERT_TRUE(clipped && free);
  EXPECT_GT(clipped->position_m2, free->position_m2);
  device.sensor_range_T = 1e-9;
  Rig blind(device, {.sizes = NoImperfections()});
  EXPECT_FALSE(CramerRao(blind, kPose, Quiet()).has_value());
}

}  // namespace test_sim_bound
}  // namespace omni::sim
