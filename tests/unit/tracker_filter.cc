// The filter learns how lively the hand is: calm hands give calm poses, and a hand that sets off is not held back.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/tracker/filter.h"

namespace omni::tracker {
namespace {

constexpr double kSigma_m = 4e-4, kSigma_rad = 5e-3, kTick_s = 1e-3;

class TrackerFilter : public testing::Test {
 protected:
  double Noise() { return std::normal_distribution<double>()(generator); }
  void Feed(const base::Vec3& position_base_m) {
    PoseMeasurement measured{position_base_m, {0, 0, -1}, {}};
    measured.position_base_m.x += kSigma_m * Noise();
    measured.position_base_m.y += kSigma_m * Noise();
    measured.position_base_m.z += kSigma_m * Noise();
    measured.axis_base = TurnAxis(measured.axis_base, {kSigma_rad * Noise(), kSigma_rad * Noise(), 0});
    for (std::size_t i = 0; i < 5; ++i)
      measured.covariance[6 * i] = i < 3 ? kSigma_m * kSigma_m : kSigma_rad * kSigma_rad;
    if (!started) {
      ResetFilter(measured, state);
    } else {
      PredictFilter(noise, kTick_s, state);
      CorrectFilter(noise, measured, kTick_s, true, state);
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

}  // namespace
}  // namespace omni::tracker
