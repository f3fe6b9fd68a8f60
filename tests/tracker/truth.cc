// The static solver against simulated rigs, which share no field code with it: model error, efficiency, search,
// hidden currents, ambient field, saturation.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "service/base/eigen.h"
#include "service/tracker/solve/static_solve.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig.h"

namespace omni::tracker {
namespace test_tracker_truth {

std::array<ArrayReading, kSensors> ReadingsOf(const base::HallScan& scan) {
  std::array<ArrayReading, kSensors> readings;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i] = {scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7u};
  }
  return readings;
}

struct Tally {
  std::vector<double> error_mm;
  double square_over_covariance = 0, turn_over_covariance = 0, nees = 0, chi2 = 0, dof = 0;
  int not_found = 0;

  void Add(const StaticPose& found, const sim::MagnetPose& truth) {
    const Eigen::Vector3d p = base::ToEigen(truth.centre_base_m), u = base::ToEigen(truth.axis_base);
    const PosePoint point = MakePosePoint(found.pose);
    Eigen::Matrix<double, kParameters, 1> e;
    e.head<3>() = found.pose.position_base_m - p;
    e[3] = -u.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_1_base.data()));
    e[4] = -u.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_2_base.data()));
    error_mm.push_back(1e3 * e.head<3>().norm());
    square_over_covariance += e.head<3>().squaredNorm() / found.covariance.topLeftCorner<3, 3>().trace();
    turn_over_covariance += e.tail<2>().squaredNorm() / found.covariance.bottomRightCorner<2, 2>().trace();
    nees += e.dot(found.covariance.inverse() * e) / kParameters;
    chi2 += found.chi2;
    dof += found.dof;
    if (found.status != StaticStatus::kFound || u.dot(found.pose.axis_base) < 0) ++not_found;
  }
  double mean() const {
    double sum = 0;
    for (const double e : error_mm) sum += e;
    return sum / static_cast<double>(error_mm.size());
  }
  double worst() const { return *std::max_element(error_mm.begin(), error_mm.end()); }
};

struct Draw {
  std::uint64_t seed = 1;
  sim::NoiseMode noise = sim::NoiseMode::kUltraHigh;
  double tilt_max_rad = std::numbers::pi / 3;
  double current_max_A = 0;
  base::Vec3 ambient_base_T{};
};

Tally Judge(const Draw& draw, const StaticOptions& options, int count) {
  const bool digital = draw.noise != sim::NoiseMode::kNone;  // else readings are the field itself
  sim::Rig rig(support::NominalDevice(), {.seed = draw.seed, .noise = draw.noise, .saturation = digital});
  base::Calibration exact = rig.ExactCalibration();
  exact.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  const auto solver = StaticSolver::Make(exact, options);
  EXPECT_TRUE(solver.ok());
  sim::Random random(draw.seed + 100);
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const sim::MagnetPose truth = rig.DrawPose({.tilt_max_rad = draw.tilt_max_rad}, random);
    sim::CoilArray current_A{};
    for (double& current : current_A) current = random.Uniform(-draw.current_max_A, draw.current_max_A);
    auto readings = ReadingsOf(rig.Scan(&truth, current_A, random));
    for (std::size_t s = 0; s < readings.size(); ++s) {
      const auto& G = exact.sensors[s].gain_sensor_base;
      const base::Vec3& B = draw.ambient_base_T;
      readings[s].field_sensor_T.x += G[0] * B.x + G[1] * B.y + G[2] * B.z;
      readings[s].field_sensor_T.y += G[3] * B.x + G[4] * B.y + G[5] * B.z;
      readings[s].field_sensor_T.z += G[6] * B.x + G[7] * B.y + G[8] * B.z;
    }
    tally.Add(solver->Solve(readings, {}), truth);
  }
  return tally;
}

TEST(TrackerTruth, NoiseFreeErrorIsBelowThirtyMicrometresAtAnyTilt) {
  const Tally tally = Judge({.seed = 21, .noise = sim::NoiseMode::kNone, .tilt_max_rad = std::numbers::pi}, {}, 1500);
  EXPECT_EQ(tally.not_found, 0);
  EXPECT_LT(tally.mean(), 0.003);
  EXPECT_LT(tally.worst(), 0.03);
}

class TrackerTruthPrecision : public testing::TestWithParam<Precision> {};

TEST_P(TrackerTruthPrecision, SingleScanErrorsMatchTheReportedCovariance) {
  constexpr int kCount = 4000;
  const Tally tally = Judge({.seed = 22}, {.precision = GetParam()}, kCount);
  EXPECT_EQ(tally.not_found, 0);
  EXPECT_NEAR(tally.square_over_covariance / kCount, 1, 0.05);
  EXPECT_NEAR(tally.turn_over_covariance / kCount, 1, 0.05);
  EXPECT_NEAR(tally.nees / kCount, 1, 0.05);
  EXPECT_NEAR(tally.chi2 / tally.dof, 1, 0.03);
}
INSTANTIATE_TEST_SUITE_P(Both, TrackerTruthPrecision, testing::Values(Precision::kFloat, Precision::kDouble));

TEST(TrackerTruth, ColdStartsFindEveryOrientation) {
  const Tally tally = Judge({.seed = 23, .tilt_max_rad = std::numbers::pi},
                            {.precision = Precision::kFloat, .cold_candidates = 6}, 5000);
  EXPECT_EQ(tally.not_found, 0);
  EXPECT_LT(tally.worst(), 10);
}

TEST(TrackerTruth, UnknownCoilCurrentsBarelyIncreaseTheError) {
  StaticOptions options;
  options.trust.currents_hidden = true;
  constexpr int kCount = 2000;
  const Tally tally = Judge({.seed = 24, .current_max_A = 15}, options, kCount);
  EXPECT_LT(tally.mean(), 0.35);
  EXPECT_NEAR(tally.nees / kCount, 1, 0.06);
  EXPECT_NEAR(tally.chi2 / tally.dof, 1, 0.04);
}

TEST(TrackerTruth, UnknownAmbientFieldIsEliminated) {
  const Draw draw{.seed = 25, .ambient_base_T = {2e-5, -1e-5, 1.5e-5}};  // 200 mG
  EXPECT_GT(Judge(draw, {}, 200).mean(), 1);
  StaticOptions options;
  options.trust.ambient_error_T = 1e-4;
  const Tally tally = Judge(draw, options, 1000);
  EXPECT_LT(tally.mean(), 0.3);
  EXPECT_NEAR(tally.nees / 1000, 1, 0.09);
}

// Shows that these tests can fail: a magnet modelled 1 % too wide is noticed.
TEST(TrackerTruth, WrongMagnetSizeIncreasesTheError) {
  base::DeviceGeometry device = support::NominalDevice();
  sim::Rig rig(device, {.seed = 26, .noise = sim::NoiseMode::kNone});
  base::Calibration wrong = rig.ExactCalibration();
  wrong.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  wrong.moment_Am2 *= 1.0201;
  wrong.magnet.radius_m *= 1.01;
  const auto solver = StaticSolver::Make(wrong, {});
  ASSERT_TRUE(solver.ok());
  sim::Random random(126);
  Tally tally;
  for (int i = 0; i < 200; ++i) {
    const sim::MagnetPose truth = rig.DrawPose({}, random);
    tally.Add(solver->Solve(ReadingsOf(rig.Scan(&truth, {}, random)), {}), truth);
  }
  EXPECT_GT(tally.mean(), 0.3);
}

}  // namespace test_tracker_truth
}  // namespace omni::tracker
