// The filter learns how lively the hand is: calm hands give calm poses, and a hand that sets off is not held back.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/tracker/filter.h"

namespace omni::tracker {
namespace test_tracker_filter {

constexpr double kSigma_m = 4e-4, kSigma_rad = 5e-3, kTick_s = 1e-3;

class TrackerFilter : public testing::Test {
 protected:
  double Noise() { return std::normal_distribution<double>()(generator); }
  void Feed(const base::Vec3& position_base_m) {
    PoseMeasurement measured{position_base_m, {0, 0, -1}, {}};
    measured.position_base_m.x += white * kSigma_m * Noise();
    measured.position_base_m.y += white * kSigma_m * Noise();
    measured.position_base_m.z += white * kSigma_m * Noise();
    measured.axis_base = TurnAxis(measured.axis_base, {white * kSigma_rad * Noise(), white * kSigma_rad * Noise(), 0});
    for (std::size_t i = 0; i < 5; ++i)
      measured.covariance[6 * i] = i < 3 ? kSigma_m * kSigma_m : kSigma_rad * kSigma_rad;
    if (!started) {
      ResetFilter(measured, state);
    } else {
      PredictFilter(noise, kTick_s, state);
      CorrectFilter(noise, measured, kTick_s, state);
    }
    started = true;
  }
  // rms distance from `at` over `ticks`.
  double RmsAt(const base::Vec3& at, int ticks) {
    double square = 0;
    for (int i = 0; i < ticks; ++i) {
      Feed(at);
      const base::Vec3& p = state.position_base_m;
      square += std::pow(p.x - at.x, 2) + std::pow(p.y - at.y, 2) + std::pow(p.z - at.z, 2);
    }
    return std::sqrt(square / ticks);
  }

  FilterNoise noise;
  FilterState state;
  bool started = false;
  double white = 1;  // standard deviation of the white part, in what the measurement claims
  std::mt19937 generator{5};
};

TEST_F(TrackerFilter, ACalmHandGivesACalmPose) {
  const base::Vec3 at{0, 0, 0.07};
  FilterNoise fixed = noise;
  fixed.calm_rate = 0;
  std::swap(noise, fixed);
  RmsAt(at, 500);
  const double without_m = RmsAt(at, 4000);
  std::swap(noise, fixed);
  RmsAt(at, 2000);
  EXPECT_LT(RmsAt(at, 4000), 0.8 * without_m);
  EXPECT_LT(state.position_liveliness.log_factor, std::log(0.2));
  EXPECT_GE(state.position_liveliness.log_factor, noise.calm_log_min - 1e-9);
}

TEST_F(TrackerFilter, AHandThatSetsOffIsNotHeldBack) {
  RmsAt({0, 0, 0.07}, 4000);
  // 10 m/s^2 for 40 ms, then 0.4 m/s.
  double x_m = 0, v_m_s = 0, worst_m = 0;
  for (int i = 0; i < 150; ++i) {
    x_m += kTick_s * (v_m_s + 0.5 * kTick_s * (i < 40 ? 10 : 0));
    v_m_s += i < 40 ? 10 * kTick_s : 0;
    Feed({x_m, 0, 0.07});
    worst_m = std::max(worst_m, std::abs(state.position_base_m.x - x_m));
  }
  EXPECT_LT(worst_m, 1.2e-3);
  EXPECT_NEAR(state.velocity_base_m_s.x, v_m_s, 0.05);
}

TEST_F(TrackerFilter, LearningStaysWithinItsBounds) {
  for (int i = 0; i < 3000; ++i) {
    const double t_s = kTick_s * i;
    Feed({0.02 * std::sin(60 * t_s), 0.02 * std::cos(60 * t_s), 0.07});
    EXPECT_LE(state.position_liveliness.log_factor, noise.calm_log_max + 1e-9);
  }
  EXPECT_GT(state.position_liveliness.log_factor, 0);
}

// A fit that is sure to 0.4 mm because of its calibration, but repeats itself to 0.04 mm, is averaged as 0.04 mm: the
// filter follows at once, and what shakes a force is small.
TEST_F(TrackerFilter, WhatDoesNotScatterIsNotNoise) {
  white = 0.1;
  RmsAt({0, 0, 0.07}, 1000);
  EXPECT_NEAR(state.position_whiteness.share, 0.01, 0.006);
  EXPECT_NEAR(state.axis_whiteness.share, 0.01, 0.006);
  EXPECT_LT(std::sqrt(state.covariance_pp[0]), 0.2 * kSigma_m);
  EXPECT_LT(RmsAt({0, 0, 0.07}, 1000), 0.2 * kSigma_m);
  white = 1;
  RmsAt({0, 0, 0.07}, 1000);
  EXPECT_GT(state.position_whiteness.share, 0.6);
}

// Motion is not taken for noise: 0.5 m/s to and fro at 2 Hz.
TEST_F(TrackerFilter, MotionIsNotNoise) {
  white = 0.1;
  for (int i = 0; i < 2000; ++i) Feed({0.04 * std::sin(2 * 3.14159265 * 2 * i * kTick_s), 0, 0.07});
  EXPECT_LT(state.position_whiteness.share, 0.02);
}

}  // namespace test_tracker_filter
}  // namespace omni::tracker
