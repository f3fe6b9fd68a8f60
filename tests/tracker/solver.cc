// Convergence, efficiency and the cold start, on the tracker's own model.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "service/tracker/tracker.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_solver {

using support::Rng;

Config PureNoiseConfig() {
  Config config = MakeConfig(support::NominalDevice());
  config.trust.model_error_relative = config.trust.coil_error_relative = 0;  // the model is the truth here
  config.trust.current_error_A = 0;
  return config;
}

TEST(TrackerSolver, ConvergesToTheNoiseFreePoseFromNearby) {
  Rng rng(1);
  const Config config = PureNoiseConfig();
  for (int i = 0; i < 1000; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.12);
    const base::HallScan scan = support::MakeScan(config.model, truth, 0, rng);
    const Measurement measurement = MakeMeasurement(config.model, config.trust, scan, {}, {});
    const Pose start{truth.position_base_m + 0.003 * support::RandomUnit(rng),
                     (truth.axis_base + 0.1 * support::RandomUnit(rng)).normalized()};
    const Fit fit = SolvePose(config.model, measurement, start, 0, 20);
    ASSERT_TRUE(fit.converged);
    EXPECT_LT((fit.pose.position_base_m - truth.position_base_m).norm(), 2e-6);
    EXPECT_LT(fit.chi2, 1e-2);
  }
}

TEST(TrackerSolver, WarmStartNeedsAtMostThreeEvaluationsOnAverage) {
  Rng rng(2);
  const Config config = PureNoiseConfig();
  int evaluations = 0;
  constexpr int kCount = 500;
  for (int i = 0; i < kCount; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.10, std::numbers::pi / 3);
    const base::HallScan scan = support::MakeScan(config.model, truth, 0, rng, {.noise_scale = 1});
    const Pose start{truth.position_base_m + 0.0005 * support::RandomUnit(rng),
                     (truth.axis_base + 0.009 * support::RandomUnit(rng)).normalized()};
    const Fit fit = SolvePose(config.model, MakeMeasurement(config.model, config.trust, scan, {}, {}), start, 0,
                              config.iterations_max);
    ASSERT_TRUE(fit.converged);
    evaluations += fit.iterations;
  }
  EXPECT_LE(evaluations, 3 * kCount);
}

// Normalised estimation error: e^T C^-1 e / n is 1 on average for a solver that reaches the bound and knows it.
TEST(TrackerSolver, ErrorsMatchTheCovariance) {
  Rng rng(3);
  const Config config = PureNoiseConfig();
  double nees = 0, chi2 = 0;
  constexpr int kCount = 3000;
  for (int i = 0; i < kCount; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.10, std::numbers::pi / 3);
    const base::HallScan scan = support::MakeScan(config.model, truth, 0, rng, {.noise_scale = 1});
    const Fit fit = SolvePose(config.model, MakeMeasurement(config.model, config.trust, scan, {}, {}), truth, 0, 20);
    ASSERT_TRUE(fit.converged);
    const PosePoint point = MakePosePoint(fit.pose);
    Eigen::Matrix<double, 5, 1> error;
    error.head<3>() = fit.pose.position_base_m - truth.position_base_m;
    error[3] = -truth.axis_base.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_1_base.data()));
    error[4] = -truth.axis_base.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_2_base.data()));
    nees += error.dot(fit.covariance.inverse() * error) / kParameters;
    chi2 += fit.chi2 / (kReadings - kParameters);
  }
  EXPECT_NEAR(nees / kCount, 1, 0.06);
  EXPECT_NEAR(chi2 / kCount, 1, 0.04);
}

TEST(TrackerSolver, ColdStartFindsThePenFromOneScan) {
  Rng rng(4);
  const Config config = PureNoiseConfig();
  int failures = 0;
  constexpr int kSeeds = 10000;
  for (int i = 0; i < kSeeds; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.18);
    const base::HallScan scan = support::MakeScan(config.model, truth, 0, rng, {.noise_scale = 1});
    State state;
    base::ToolState tool;
    Update(config, scan, state, tool);
    const double error_m = (base::ToEigen(tool.position_base_m) - truth.position_base_m).norm();
    const double bound_m = truth.position_base_m.norm() < 0.11 ? 0.006 : 0.03;
    if (tool.status != base::TrackingStatus::kTracking || !(error_m < bound_m)) {
      ++failures;
      ADD_FAILURE() << "seed " << i << " r " << truth.position_base_m.norm() << " status "
                    << static_cast<int>(tool.status) << " error " << error_m << " chi2 " << tool.chi2 << " iterations "
                    << tool.iterations;
    }
  }
  EXPECT_EQ(failures, 0);
}

TEST(TrackerSolver, ColdStartWorksWithHalfTheSensors) {
  Rng rng(5);
  const Config config = PureNoiseConfig();
  for (int i = 0; i < 500; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.08);
    base::HallScan scan = support::MakeScan(config.model, truth, 0, rng, {.noise_scale = 1});
    for (int missing = 0; missing < 4; ++missing) {
      scan.field_sensor_T[static_cast<std::size_t>((i + 2 * missing) % 8)].y = std::nan("");
      scan.saturated_mask |= 5u << (3 * ((i + 2 * missing) % 8));
    }
    State state;
    base::ToolState tool;
    Update(config, scan, state, tool);
    ASSERT_EQ(tool.status, base::TrackingStatus::kTracking) << "seed " << i;
    EXPECT_EQ(tool.dof, 12 - kParameters);
    EXPECT_LT((base::ToEigen(tool.position_base_m) - truth.position_base_m).norm(), 0.01);
  }
}

}  // namespace test_tracker_solver
}  // namespace omni::tracker
