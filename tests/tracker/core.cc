// The core's remanence after a motion (hysteresis), followed along the pen's path. docs/theory/tracking.md (9.4)
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "service/tracker/room/drift.h"
#include "tests/support/numeric.h"

namespace omni::tracker {
namespace test_tracker_core {

using base::Vec3;

constexpr double kKept_A = 0.012;

// The tests set the core's moment directly.
class TrackerCoreString : public testing::Test {
 protected:
  DriftNoise noise{.core_kept_A = kKept_A};
  DriftState drift;
  std::array<double, 3> current_A{};
  PenPlace pen{.position_base_m = {0, 0, 0.09}, .axis_base = {0, 0, -1}};

  void MoveTo(const Vec3& core_A, const std::array<double, 3>& current_step_A = {}) {
    pen.core_A = core_A;
    pen.position_base_m = {0.1 * core_A.x, 0.1 * core_A.y, 0.09};
    for (std::size_t k = 0; k < 3; ++k) current_A[k] += current_step_A[k];
    FollowCore(noise, current_A, &pen, drift);
    PredictDrift(noise, drift.t_ns + 4'000'000, &pen, drift);
  }
  double Kept_A(std::size_t k) const { return drift.mean[k]; }
};

TEST_F(TrackerCoreString, RemanenceTrailsTheMomentAndTurnsWithIt) {
  MoveTo({});
  for (int n = 1; n <= 60; ++n) MoveTo({0.002 * n, 0, 0});
  EXPECT_NEAR(Kept_A(0), -kKept_A, 1e-12);
  EXPECT_NEAR(drift.covariance[0], std::pow(noise.core_error * kKept_A, 2), 0.1 * drift.covariance[0]);
  for (int n = 1; n <= 6; ++n) MoveTo({0.12 - 0.002 * n, 0, 0});  // as far back as it is long
  EXPECT_NEAR(Kept_A(0), 0, 1e-12);
  for (int n = 1; n <= 40; ++n) MoveTo({0.108, 0.002 * n, 0});
  EXPECT_NEAR(Kept_A(1), -kKept_A, 1e-3 * kKept_A);
  EXPECT_NEAR(Kept_A(0), 0, 1e-3 * kKept_A);
}

TEST_F(TrackerCoreString, RemanenceDoesNotDependOnSpeed) {
  std::array<double, 2> kept_A{};
  for (const int steps : {4, 400}) {
    drift = {};
    MoveTo({});
    for (int n = 1; n <= steps; ++n) {
      const double angle = 2.0 * n / steps;
      MoveTo({0.008 * std::sin(angle), 0.008 * angle, 0});
    }
    kept_A[steps == 400] = Kept_A(0);
  }
  EXPECT_NEAR(kept_A[0], kept_A[1], 0.05 * kKept_A);
}

// With a position known to .3 mm only, moving back and forth is no travel.
TEST_F(TrackerCoreString, NoiseDoesNotDragTheRemanence) {
  MoveTo({});
  MoveTo({0.03, 0, 0});
  support::Rng rng{5};
  for (int n = 0; n < 10000; ++n) {
    MoveTo({0.03 + support::Uniform(rng, -0.001, 0.001), support::Uniform(rng, -0.001, 0.001), 0});
  }
  EXPECT_NEAR(Kept_A(0), -kKept_A, 0.002);
  EXPECT_NEAR(Kept_A(1), 0, 0.002);
}

TEST_F(TrackerCoreString, CoilCurrentsDragTheRemanence) {
  MoveTo({});
  MoveTo({}, {0, 0, 3.0});
  EXPECT_NEAR(Kept_A(2), -kKept_A, 1e-12);
  MoveTo({}, {0, 0, -1.0});
  EXPECT_NEAR(Kept_A(2), kKept_A, 1e-12);
}

// For each scan, since a current of 100 Hz reverses it twice in ten: PredictDrift is called at every fourth only.
TEST_F(TrackerCoreString, RemanenceIsUpdatedBetweenPredictions) {
  MoveTo({});
  for (const double step_A : {0.1, 0.1, -0.1, -0.1}) {
    current_A[2] += step_A;
    FollowCore(noise, current_A, &pen, drift);
    EXPECT_NEAR(Kept_A(2), -std::copysign(kKept_A, step_A), 1e-12);
  }
}

TEST_F(TrackerCoreString, RemanenceDecaysWithoutThePen) {
  MoveTo({});
  MoveTo({0.03, 0, 0});
  for (int n = 0; n < 500; ++n) {
    FollowCore(noise, current_A, nullptr, drift);
    PredictDrift(noise, drift.t_ns + 10'000'000, nullptr, drift);
  }
  EXPECT_NEAR(Kept_A(0), 0, 0.01 * kKept_A);
  EXPECT_GT(drift.covariance[0], kKept_A * kKept_A / 3);
  MoveTo({-0.03, 0, 0});  // it may have been anywhere between
  EXPECT_NEAR(Kept_A(0), 0, 0.01 * kKept_A);
}

}  // namespace test_tracker_core
}  // namespace omni::tracker
