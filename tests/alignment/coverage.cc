// The quality figure predicts the error: over many seeded fits the true error, in units of what was predicted, has the
// size that it must have, for independent and for correlated noise.
#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Dense>

#include "service/alignment/fit.h"
#include "tests/support/rig/alignment_scenario.h"

namespace omni::alignment {
namespace test_alignment_coverage {

using test::AlignmentScenario;

constexpr base::Vec3 kTip{0.01, -0.02, -0.1};
constexpr int kFits = 200;

struct Coverage {
  double squares = 0, predicted = 0, chi2 = 0;
  int fits = 0, within = 0;
  void Add(const Outcome& outcome, const Rigid& truth) {
    const double error_m = Distance_m(outcome.base_space, truth, kWorkingPoint_base_m);
    squares += error_m * error_m;
    predicted += outcome.expected_error_m * outcome.expected_error_m;
    within += error_m <= 2 * outcome.expected_error_m;
    // (rotation vector in L, position): truth = exp(w) found
    const Eigen::Quaterniond turn =
        base::ToEigen(truth.orientation) * base::ToEigen(outcome.base_space.orientation).conjugate();
    const Eigen::AngleAxisd w(turn);
    Eigen::Matrix<double, 6, 1> e;
    e << w.angle() * w.axis(), base::ToEigen(truth.position_m) - base::ToEigen(outcome.base_space.position_m);
    const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> P(outcome.covariance.data());
    chi2 += e.dot(P.ldlt().solve(e)) / 6;
    ++fits;
  }
  double ratio() const { return std::sqrt(squares / predicted); }
};

// Independent noise of any size, expected or not: the residuals show it.
TEST(AlignmentCoverage, SweepErrorMatchesPredictionUnderIndependentNoise) {
  for (const double noise_m : {0.5e-3, 1.5e-3, 2.5e-3}) {
    Coverage coverage;
    for (unsigned seed = 0; seed < kFits; ++seed) {
      AlignmentScenario scenario(seed);
      const Rigid truth = scenario.AnyBase();
      std::vector<Sample> samples;
      for (int i = 0; i < 150; ++i) samples.push_back(scenario.At(truth, scenario.PointOfBase(), kTip, noise_m, 0));
      Prior prior;
      prior.level = false;
      const auto outcome = FitBasePose(samples, prior, {});
      ASSERT_TRUE(outcome.ok()) << outcome.error();
      coverage.Add(*outcome, truth);
    }
    EXPECT_NEAR(coverage.ratio(), 1, 0.12) << noise_m;
    EXPECT_NEAR(coverage.chi2 / coverage.fits, 1, 0.15) << noise_m;
    EXPECT_GT(coverage.within, 0.93 * kFits) << noise_m;
  }
}

// Five touches leave few residuals: there the expected noise helps. It is right here.
TEST(AlignmentCoverage, FiveTouchErrorMatchesPrediction) {
  const base::Vec3 marks[] = {{0.0618, -0.0508, -0.07},
                              {0.052, 0.0608, -0.07},
                              {-0.0311, 0.0737, -0.07},
                              {-0.079, -0.0126, -0.07},
                              {0, 0, 0.0375}};
  for (const bool level : {true, false}) {
    Coverage coverage;
    for (unsigned seed = 0; seed < kFits; ++seed) {
      AlignmentScenario scenario(seed);
      Rigid truth = scenario.LevelBase();
      const Eigen::Vector3d tilt = scenario.Normal(0.00873);
      const Eigen::Quaterniond tilted(
          Eigen::AngleAxisd(std::hypot(tilt.x(), tilt.z()), Eigen::Vector3d(tilt.x(), 0, tilt.z()).normalized()));
      truth.orientation = base::FromEigen((tilted * base::ToEigen(truth.orientation)).normalized());
      Prior prior;
      prior.level = level;
      prior.tip_controller_m = base::FromEigen(Eigen::Vector3d(base::ToEigen(kTip) + scenario.Normal(0.5e-3)));
      prior.tip_sigma_m = 0.5e-3;
      std::vector<Sample> samples;
      for (int i = 0; i < 5; ++i) samples.push_back(scenario.At(truth, marks[i], kTip, 1.5e-3, i));
      const auto outcome = FitBasePose(samples, prior, {});
      ASSERT_TRUE(outcome.ok()) << outcome.error();
      coverage.Add(*outcome, truth);
    }
    EXPECT_NEAR(coverage.ratio(), 1, 0.15) << level;
    EXPECT_GT(coverage.within, 0.92 * kFits) << level;
  }
}

// Noise that lasts: without the correlation the prediction would be several times too good.
TEST(AlignmentCoverage, PredictionAccountsForCorrelatedNoise) {
  Coverage coverage;
  double correlation = 0;
  for (unsigned seed = 0; seed < kFits; ++seed) {
    AlignmentScenario scenario(seed);
    const Rigid truth = scenario.LevelBase();
    std::vector<Sample> samples;
    Eigen::Vector3d drift = scenario.Normal(1.5e-3);
    constexpr double kKeep = 0.92;  // 12 samples
    for (int i = 0; i < 600; ++i) {
      drift = kKeep * drift + std::sqrt(1 - kKeep * kKeep) * scenario.Normal(1.5e-3);
      Sample sample = scenario.At(truth, scenario.PointOfBase(), kTip, 0.3e-3, 0);
      base::Vec3& p = sample.controller_space.position_m;
      p = base::FromEigen(Eigen::Vector3d(base::ToEigen(p) + drift));
      samples.push_back(sample);
    }
    const auto outcome = FitBasePose(samples, {}, {});
    ASSERT_TRUE(outcome.ok()) << outcome.error();
    coverage.Add(*outcome, truth);
    correlation += outcome->correlation / kFits;
  }
  EXPECT_GT(correlation, 10);
  EXPECT_GT(coverage.ratio(), 0.6);
  EXPECT_LT(coverage.ratio(), 1.25);
}

}  // namespace test_alignment_coverage
}  // namespace omni::alignment
