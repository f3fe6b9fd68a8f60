// The filter's three models of a hand: rests are calm, starts and stops are followed at once and without overshoot, and
// the covariance holds through them.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <random>
#include <string>
#include <vector>

#include "service/base/eigen.h"
#include "service/tools/common/row_table.h"
#include "service/tracker/filter/filter.h"

namespace omni::tracker {
namespace test_tracker_filter {

using Eigen::Vector3d;
using tools::Quantile;

constexpr double kTick_s = 1e-3;

// Of a calibrated base in its fast setting, across the direction from the core; along it, distance is known better.
struct FitNoise {
  double position_m, axis_rad;
};
constexpr FitNoise kAt55mm{3.1e-4, 6e-3}, kAt90mm{8.2e-4, 1.5e-2};

// A filter that is fed with noisy poses.
class Fed {
 public:
  explicit Fed(const FitNoise& fit, unsigned seed = 5) : fit_(fit), generator_(seed) {}

  void Feed(const Vector3d& position_m, const Vector3d& axis = -Vector3d::UnitZ()) {
    const base::Vec3 u = base::FromEigen(axis);
    Vector3d tilt = NoiseVector();
    tilt -= tilt.dot(axis) * axis;
    PoseMeasurement measured{base::FromEigen(position_m + white * fit_.position_m * NoiseVector()),
                             TurnAxis(u, base::FromEigen(white * fit_.axis_rad * tilt)),
                             {}};
    for (std::size_t i = 0; i < 5; ++i)
      measured.covariance[6 * i] = std::pow(i < 3 ? fit_.position_m : fit_.axis_rad, 2);
    if (!started_) {
      ResetFilter(noise, measured, state);
    } else {
      PredictFilter(noise, kTick_s, pushed, state);
      CorrectFilter(noise, measured, kTick_s, state);
    }
    started_ = true;
  }
  // rms distance from `at_m` over `ticks`.
  double RmsAt(const Vector3d& at_m, int ticks) {
    double square = 0;
    for (int i = 0; i < ticks; ++i) {
      Feed(at_m);
      square += (Position() - at_m).squaredNorm();
    }
    return std::sqrt(square / ticks);
  }
  Vector3d NoiseVector() { return {normal_(generator_), normal_(generator_), normal_(generator_)}; }
  Vector3d Position() const { return base::ToEigen(state.position_base_m); }
  double Nees(const Vector3d& truth_m) const {
    const Eigen::Map<const Eigen::Matrix3d> P(state.covariance_pp.data());
    const Vector3d error = Position() - truth_m;
    return error.dot(P.inverse() * error) / 3;
  }

  FilterNoise noise;
  FilterState state;
  bool pushed = false;
  double white = 1;  // standard deviation of the white part, in what the measurement claims

 private:
  FitNoise fit_;
  bool started_ = false;
  std::mt19937 generator_;
  std::normal_distribution<double> normal_;
};

TEST(TrackerFilter, CalmHandIsSmoothedBelowTheFitNoise) {
  Fed hand(kAt55mm);
  const Vector3d at{0, 0, 0.055};
  hand.RmsAt(at, 2000);
  EXPECT_LT(hand.RmsAt(at, 4000), 0.4 * std::sqrt(3) * kAt55mm.position_m);
  EXPECT_GT(hand.state.motions.likely[kAtRest], 0.5);
  EXPECT_LT(hand.state.position_liveliness.log_factor, std::log(0.2));
  EXPECT_GE(hand.state.position_liveliness.log_factor, hand.noise.calm_log_min - 1e-9);
}

TEST(TrackerFilter, HandStartingToMoveIsFollowed) {
  Fed hand({4e-4, 5e-3});
  hand.RmsAt({0, 0, 0.07}, 4000);
  // 10 m/s^2 for 40 ms, then 0.4 m/s.
  double x_m = 0, v_m_s = 0, worst_m = 0;
  for (int i = 0; i < 150; ++i) {
    x_m += kTick_s * (v_m_s + 0.5 * kTick_s * (i < 40 ? 10 : 0));
    v_m_s += i < 40 ? 10 * kTick_s : 0;
    hand.Feed({x_m, 0, 0.07});
    worst_m = std::max(worst_m, std::abs(hand.state.position_base_m.x - x_m));
  }
  EXPECT_LT(worst_m, 1.2e-3);
  EXPECT_NEAR(hand.state.velocity_base_m_s.x, v_m_s, 0.05);
}

struct Change {
  FitNoise fit;
  double acceleration_m_s2;
  double p95_m, peak_median_m_s, peak_p95_m_s;  // what it may be
};

class TrackerFilterChanges : public testing::TestWithParam<Change> {
 protected:
  static constexpr double kSpeed_m_s = 0.5;
  static constexpr int kTrials = 150, kBefore = 300, kAfter = 150;

  // From rest to .5 m/s, or the other way round, in a random direction.
  void Run(bool stops) {
    for (unsigned trial = 0; trial < kTrials; ++trial) {
      Fed hand(GetParam().fit, trial + 1);
      const Vector3d direction = hand.NoiseVector().normalized();
      double gone_m = 0, speed_m_s = stops ? kSpeed_m_s : 0, error_m = 0, peak_m_s = 0;
      for (int tick = 0; tick < kBefore + kAfter; ++tick) {
        const double change_m_s = tick < kBefore ? 0 : kTick_s * GetParam().acceleration_m_s2 * (stops ? -1 : 1);
        const double next_m_s = std::clamp(speed_m_s + change_m_s, 0.0, kSpeed_m_s);
        gone_m += kTick_s * (speed_m_s + next_m_s) / 2;
        speed_m_s = next_m_s;
        hand.Feed(gone_m * direction);
        if (tick < kBefore) continue;
        error_m = std::max(error_m, (hand.Position() - gone_m * direction).norm());
        peak_m_s = std::max(peak_m_s, base::ToEigen(hand.state.velocity_base_m_s).norm());
        nees += hand.Nees(gone_m * direction) / (kTrials * kAfter);
      }
      errors_m.push_back(error_m);
      peaks_m_s.push_back(peak_m_s);
    }
  }

  std::vector<double> errors_m, peaks_m_s;
  double nees = 0;
};

TEST_P(TrackerFilterChanges, StartIsFollowedWithoutOvershoot) {
  Run(false);
  EXPECT_LT(Quantile(errors_m, 0.95), GetParam().p95_m);
  EXPECT_LT(Quantile(errors_m, 1), 1.5 * GetParam().p95_m);
  EXPECT_LT(Quantile(peaks_m_s, 0.5), GetParam().peak_median_m_s);
  EXPECT_LT(Quantile(peaks_m_s, 0.95), GetParam().peak_p95_m_s);
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 1.5);
}

TEST_P(TrackerFilterChanges, StopIsFollowed) {
  Run(true);
  EXPECT_LT(Quantile(errors_m, 0.95), 1.1 * GetParam().p95_m);
  EXPECT_GT(nees, 0.4);
  EXPECT_LT(nees, 1.5);
}

INSTANTIATE_TEST_SUITE_P(Hands, TrackerFilterChanges,
                         testing::Values(Change{kAt55mm, 5, 1e-3, 0.65, 0.75}, Change{kAt55mm, 20, 1e-3, 0.65, 0.75},
                                         Change{kAt55mm, 100, 1.05e-3, 0.65, 0.75}, Change{kAt90mm, 5, 2e-3, 0.65, 0.8},
                                         Change{kAt90mm, 20, 2e-3, 0.65, 0.8}, Change{kAt90mm, 100, 2e-3, 0.65, 0.8}),
                         [](const auto& test) {
                           return "At" + std::string(test.param.fit.position_m < 5e-4 ? "55" : "90") + "mm" +
                                  std::to_string(static_cast<int>(test.param.acceleration_m_s2)) + "ms2";
                         });

// Response to a sine: gain and delay.
//   2 / (n a) sum x_k exp(-i w t_k) = gain exp(-i w delay) / i
struct Response {
  double gain, delay_s;
};

Response ResponseTo(double amplitude_m, double frequency_Hz, const FitNoise& fit, bool pushed) {
  const double rate_1_s = 2 * 3.14159265358979 * frequency_Hz;
  std::complex<double> sum;
  int n = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Fed hand(fit, seed);
    hand.pushed = pushed;
    for (int tick = 0; tick < 3000; ++tick) {
      const double phase = rate_1_s * kTick_s * tick;
      hand.Feed({amplitude_m * std::sin(phase), 0, 0.07});
      if (tick < 1000) continue;
      sum += hand.state.position_base_m.x * std::polar(1.0, -phase);
      ++n;
    }
  }
  const std::complex<double> c = std::complex<double>(0, 1) * sum * (2 / (n * amplitude_m));
  return {std::abs(c), -std::arg(c) / rate_1_s};
}

void Tremble(const FitNoise& fit, double gain_min, double gain_max, double delay_max_s) {
  const Response response = ResponseTo(2e-4, 10, fit, false);
  EXPECT_GT(response.gain, gain_min);
  EXPECT_LT(response.gain, gain_max);
  EXPECT_LT(response.delay_s, delay_max_s);
}

TEST(TrackerFilter, TremorKeepsItsAmplitude) {
  Tremble(kAt55mm, 0.9, 1.1, 4e-3);
  Tremble(kAt90mm, 0.8, 1.25, 8e-3);
}

// Motion no larger than the noise, as of a pen that leans on a wall: leaving rest is detected late.
TEST(TrackerFilter, PushedPenIsNotTreatedAsResting) {
  const FitNoise fit{1e-4, 5e-3};
  const Response pushed = ResponseTo(5e-5, 8, fit, true), rests = ResponseTo(5e-5, 8, fit, false);
  EXPECT_LT(pushed.delay_s, 0.5 * rests.delay_s);
  EXPECT_GT(pushed.gain, 0.8);
  EXPECT_LT(pushed.gain, 1.25);
}

// A working hand: error of the pose, and of its prediction 20 ms ahead.
TEST(TrackerFilter, WavedPenIsFollowedAndPredicted) {
  Fed hand(kAt55mm);
  double square = 0, ahead_square = 0;
  const auto at = [](double t_s) {
    return Vector3d(0.04 * std::sin(8.2 * t_s), 0.03 * std::cos(5.7 * t_s), 0.07 + 0.01 * std::sin(12.6 * t_s));
  };
  for (int tick = 0; tick < 3500; ++tick) {
    const double t_s = kTick_s * tick;
    hand.Feed(at(t_s));
    if (tick < 500) continue;
    const Vector3d ahead = hand.Position() + 0.02 * base::ToEigen(hand.state.velocity_base_m_s);
    square += (hand.Position() - at(t_s)).squaredNorm() / 3000;
    ahead_square += (ahead - at(t_s + 0.02)).squaredNorm() / 3000;
  }
  EXPECT_LT(std::sqrt(square), 3e-4);
  EXPECT_LT(std::sqrt(ahead_square), 1.4e-3);
}

// The axis starts to turn at 5 rad/s while the position stays.
TEST(TrackerFilter, AxisStartingToTurnIsFollowed) {
  double worst_rad = 0, peak_rad_s = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Fed hand(kAt55mm, seed);
    double angle = 0;
    for (int tick = 0; tick < 450; ++tick) {
      angle += tick < 300 ? 0 : 5e-3;
      const Vector3d axis(std::sin(angle), 0, -std::cos(angle));
      hand.Feed({0, 0, 0.055}, axis);
      if (tick < 300) continue;
      worst_rad = std::max(worst_rad, (base::ToEigen(hand.state.axis_base) - axis).norm());
      peak_rad_s = std::max(peak_rad_s, base::ToEigen(hand.state.angular_velocity_base_rad_s).norm());
      EXPECT_NEAR(base::ToEigen(hand.state.axis_base).norm(), 1, 1e-12);
    }
  }
  EXPECT_LT(worst_rad, 0.03);
  EXPECT_LT(peak_rad_s, 9);
}

TEST(TrackerFilter, LivelinessStaysWithinItsBounds) {
  Fed hand(kAt55mm);
  for (int i = 0; i < 3000; ++i) {
    const double t_s = kTick_s * i;
    hand.Feed({0.02 * std::sin(60 * t_s), 0.02 * std::cos(60 * t_s), 0.07});
    EXPECT_LE(hand.state.position_liveliness.log_factor, hand.noise.calm_log_max + 1e-9);
  }
  EXPECT_GT(hand.state.position_liveliness.log_factor, 0);
}

// A fit with a stated error of 0.4 mm because of its calibration, but repeatable to 0.04 mm, is averaged as 0.04 mm:
// the filter follows at once, and the noise in a force is small.
TEST(TrackerFilter, RepeatableFitsReduceTheAssumedNoise) {
  Fed hand(kAt55mm);
  hand.white = 0.1;
  hand.RmsAt({0, 0, 0.07}, 1000);
  EXPECT_NEAR(hand.state.position_whiteness.share, 0.01, 0.006);
  EXPECT_NEAR(hand.state.axis_whiteness.share, 0.01, 0.006);
  EXPECT_LT(std::sqrt(hand.state.covariance_pp[0]), 0.2 * kAt55mm.position_m);
  EXPECT_LT(hand.RmsAt({0, 0, 0.07}, 1000), 0.2 * kAt55mm.position_m);
  hand.white = 1;
  hand.RmsAt({0, 0, 0.07}, 1000);
  EXPECT_GT(hand.state.position_whiteness.share, 0.6);
}

// Motion is not taken for noise: 0.5 m/s to and fro at 2 Hz.
TEST(TrackerFilter, MotionIsNotTakenForNoise) {
  Fed hand(kAt55mm);
  hand.white = 0.1;
  for (int i = 0; i < 2000; ++i) hand.Feed({0.04 * std::sin(2 * 3.14159265 * 2 * i * kTick_s), 0, 0.07});
  EXPECT_LT(hand.state.position_whiteness.share, 0.02);
}

TEST(TrackerModels, MixingReachesTheStationaryDistribution) {
  const TransitionRates rates{{{0, 40, 20}, {0.5, 0, 3}, {1, 450, 0}}};
  const Mixing mixing = Mix(rates, kTick_s, {0.5, 0.3, 0.2});
  double sum = 0;
  for (std::size_t j = 0; j < kModels; ++j) {
    sum += mixing.likely[j];
    EXPECT_NEAR(mixing.parts[j][0] + mixing.parts[j][1] + mixing.parts[j][2], 1, 1e-12);
  }
  EXPECT_NEAR(sum, 1, 1e-12);
  // After a long time, the stationary probabilities: mu T = mu.
  Likely likely{1, 0, 0};
  for (int i = 0; i < 10000; ++i) likely = Mix(rates, 0.1, likely).likely;
  const double leaves[] = {60, 3.5, 451};
  for (std::size_t j = 0; j < kModels; ++j) {
    double comes = 0;
    for (std::size_t i = 0; i < kModels; ++i)
      comes += likely[i] * (1 - std::exp(-0.1 * leaves[i])) * rates[i][j] / leaves[i];
    EXPECT_NEAR(comes, likely[j] * (1 - std::exp(-0.1 * leaves[j])), 1e-9);
  }
}

TEST(TrackerModels, NoModelProbabilityReachesZero) {
  Likely likely{0.3, 0.3, 0.4};
  for (int i = 0; i < 100; ++i) UpdateProbabilities({-1e6, 0, -2e6}, likely);
  EXPECT_GT(likely[0], 0);
  EXPECT_GT(likely[2], 0);
  UpdateProbabilities({0, -20, -20}, likely);
  EXPECT_GT(likely[0], 0.9);
}

}  // namespace test_tracker_filter
}  // namespace omni::tracker
