// The gap's closed form against the nearest of many points of the cylinder.
#include <gtest/gtest.h>

#include <numbers>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "service/tracker/solve/gap.h"
#include "tests/support/numeric.h"

namespace omni::tracker {
namespace test_tracker_gap {

using Eigen::Vector3d;

// Least distance from the origin to faces and side, sampled: never below the truth, above it by at most the spacing.
double SampledDistance(const Vector3d& c, const Vector3d& u, double radius, double half_height) {
  const magnetics::TangentBasis e = magnetics::MakeTangentBasis(u);
  double least = 1e9;
  for (int ring = 0; ring <= 40; ++ring) {
    for (int sector = 0; sector < 240; ++sector) {
      const double phi = 2 * std::numbers::pi * sector / 240;
      const Vector3d out = std::cos(phi) * e.e1 + std::sin(phi) * e.e2;
      for (const double side : {-1.0, 1.0}) {
        least = std::min(least, (c + radius * ring / 40 * out + side * half_height * u).norm());
      }
      least = std::min(least, (c + radius * out + half_height * (ring / 20.0 - 1) * u).norm());
    }
  }
  return least;
}

TEST(TrackerGap, MatchesSampledSurface) {
  support::Rng rng(1);
  for (int i = 0; i < 300; ++i) {
    const Vector3d u = support::RandomUnit(rng);
    const Vector3d c = support::Uniform(rng, 0.02, 0.1) * support::RandomUnit(rng);
    const double radius = support::Uniform(rng, 0.003, 0.018), half_height = support::Uniform(rng, 0.001, 0.018);
    const double height = c.dot(u);
    if (std::abs(height) < half_height && (c - height * u).norm() < radius) continue;  // the origin is inside
    const double gap = CylinderGap(base::FromEigen(c), base::FromEigen(u), radius, half_height, 0.0375);
    const double sampled = SampledDistance(c, u, radius, half_height) - 0.0375;
    EXPECT_LE(gap, sampled + 1e-12);
    EXPECT_GE(gap, sampled - 1e-4);
  }
}

TEST(TrackerGap, MatchesAnalyticValuesAtKnownPoses) {
  EXPECT_NEAR(CylinderGap({0, 0, 0.041}, {0, 0, -1}, 0.015, 0.0035, 0.0375), 0, 1e-15);      // contact
  EXPECT_NEAR(CylinderGap({0, 0, 0.0625}, {1, 0, 0}, 0.015, 0.0035, 0.0375), 0.010, 1e-15);  // on edge
  EXPECT_LT(CylinderGap({0, 0, 0.039}, {0, 0, 1}, 0.015, 0.0035, 0.0375), 0);
  EXPECT_NEAR(CylinderGap({0, 0, 0}, {0, 0, 1}, 0.015, 0.0035, 0.0375), -0.041, 1e-15);  // deepest
}

}  // namespace test_tracker_gap
}  // namespace omni::tracker
