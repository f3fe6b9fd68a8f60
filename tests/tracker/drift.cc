// Quantities that drift while the pen is used, what the scene does without them, and what limits a pose.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_drift {

using base::TrackingStatus;
using Eigen::Vector3d;

class TrackerDrift : public testing::Test {
 protected:
  base::Calibration calibration = magnetics::NominalCalibration(support::NominalDevice());
  Config config = MakeConfig(calibration);
  Model world = config.model;  // what the readings are made with
  std::array<double, 3> remanence_A{};
  Vector3d ambient_base_T = Vector3d::Zero();
  State state;
  base::ToolState tool;
  support::Rng rng{17};
  std::int64_t t_ns = 1'000'000'000;
  Pose pose{{0.01, -0.005, 0.060}, Vector3d(0.1, 0.2, -1).normalized()};
  double noise_scale = 1;

  // Slow circles over the base, tilting.
  void Move(double t_s) {
    pose.position_base_m = {0.02 * std::cos(4 * t_s), 0.02 * std::sin(4 * t_s), 0.060 + 0.01 * std::sin(3 * t_s)};
    pose.axis_base = Vector3d(0.4 * std::sin(2 * t_s), 0.4 * std::cos(2.5 * t_s), -1).normalized();
  }
  base::HallScan NextScan() {
    t_ns += 1'000'000;
    base::HallScan scan = support::MakeScan(world, pose, t_ns, rng, {noise_scale, remanence_A});
    scan.coil_current_A = {};
    scan.sequence = static_cast<std::uint64_t>(t_ns / 1'000'000);
    for (std::size_t i = 0; i < kSensors; ++i) support::AddField(world, i, ambient_base_T, scan);
    return scan;
  }
  void Feed(const base::HallScan& scan) {
    const loop::AllocProbe probe;
    Update(config, scan, state, tool);
    EXPECT_EQ(probe.count(), 0u);
  }
  // Mean error over the last half of `seconds` of motion, from a fresh start.
  double RunMoving_m(double seconds) {
    double sum = 0;
    state = {};
    const int scans = static_cast<int>(1000 * seconds);
    for (int i = 0; i < scans; ++i) {
      Move(1e-3 * i);
      Feed(NextScan());
      EXPECT_EQ(tool.status, TrackingStatus::kTracking);
      if (2 * i >= scans) sum += (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm();
    }
    return 2 * sum / scans;
  }
};

TEST_F(TrackerDrift, MomentFollowsAWarmingMagnet) {
  const double undisturbed_m = RunMoving_m(4);
  base::Calibration warm = calibration;
  warm.moment_Am2 *= 0.985;  // 12 K
  world = MakeModel(warm);
  EXPECT_LT(RunMoving_m(4), 1.3 * undisturbed_m);
  EXPECT_NEAR(MomentScale(state.room.drift), 0.985, 0.003);
  config.drift.enabled = false;
  EXPECT_GT(RunMoving_m(1), 1.5 * undisturbed_m);
}

// A magnet cannot be exchanged while it is tracked.
TEST_F(TrackerDrift, MomentOfATrackedPenStaysWithinItsBounds) {
  RunMoving_m(1);
  base::Calibration other = calibration;
  other.moment_Am2 *= 1.08;
  world = MakeModel(other);
  noise_scale = 0;
  for (int i = 1000; i < 3000; ++i) {
    Move(1e-3 * i);
    Feed(NextScan());
    ASSERT_LE(std::abs(MomentScale(state.room.drift) - 1), 0.05 + 1e-12);
  }
}

// From its first scan on, whatever the magnet, and nothing of the own pen's precision is lost.
TEST_F(TrackerDrift, MomentOfAnotherPenIsFound) {
  const double own_m = RunMoving_m(2);
  for (const double scale : {0.7, 0.75, 0.85, 0.9, 0.95, 1.05, 1.1, 1.2, 1.25, 1.3}) {
    SCOPED_TRACE(scale);
    base::Calibration other = calibration;
    other.moment_Am2 *= scale;
    world = MakeModel(other);
    state = {};
    int tracked = 0;
    for (int i = 0; i < 50; ++i) {
      Move(1e-3 * i);
      Feed(NextScan());
      if (tool.status != TrackingStatus::kTracking) continue;
      ++tracked;
      const double sigma_m = std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
      EXPECT_LT((base::ToEigen(tool.position_base_m) - pose.position_base_m).norm(), 4 * sigma_m);
    }
    EXPECT_GE(tracked, 25);
    EXPECT_NEAR(tool.moment_scale, scale, 4 * tool.moment_sigma);
    double sum_m = 0;
    for (int i = 50; i < 2050; ++i) {
      Move(1e-3 * i);
      Feed(NextScan());
      ASSERT_EQ(tool.status, TrackingStatus::kTracking);
      sum_m += (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm() / 2000;
    }
    EXPECT_EQ(tool.magnet, base::MagnetIdentity::kNew);
    EXPECT_LT(sum_m, 1.5 * own_m / std::min(1.0, scale));
  }
}

TEST_F(TrackerDrift, RemanenceAndAmbientFieldAreEstimated) {
  config.filter.calm_rate = 0;  // what drifts, not what the filter makes of noise
  const double undisturbed_m = RunMoving_m(8);
  remanence_A = {0.011, -0.008, 0.011};
  ambient_base_T = {4e-7, -4e-7, 3e-7};  // 4 mG
  const double with_m = RunMoving_m(8);
  config.drift.enabled = false;
  const double without_m = RunMoving_m(8);
  EXPECT_LT(with_m, 1.3 * undisturbed_m);
  EXPECT_LT(with_m, 0.9 * without_m);
}

TEST_F(TrackerDrift, TracksWithoutKnowingTheCoilCurrents) {
  config.trust.currents_hidden = true;
  remanence_A = {9, -12, 14};  // not reported
  double sum_m = 0;
  for (int i = 0; i < 1000; ++i) {
    Move(1e-3 * i);
    Feed(NextScan());
    ASSERT_EQ(tool.status, TrackingStatus::kTracking);
    EXPECT_EQ(tool.dof, kReadings - 3 - kParameters);
    if (i >= 500) sum_m += (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm() / 500;
  }
  EXPECT_LT(sum_m, 8e-4);
}

TEST_F(TrackerDrift, ReportsTiltedCoarseAndSaturatedLimits) {
  for (int i = 0; i < 30; ++i) Feed(NextScan());
  EXPECT_EQ(tool.limits, 0u);
  pose = {{0, 0, 0.075}, Vector3d(1, 0, 0.05).normalized()};
  for (int i = 0; i < 3; ++i) Feed(NextScan());
  EXPECT_EQ(tool.limits & base::kToolTilted, base::kToolTilted);
  for (int i = 0; i <= 100; ++i) {  // away, not at once: a first pose is none there
    pose = {{0.001 * i, 0, 0.09 + 0.001 * i}, Vector3d(0, 0, -1)};
    Feed(NextScan());
  }
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_EQ(tool.limits & base::kToolCoarse, base::kToolCoarse);
  pose = {{0.01, -0.005, 0.060}, Vector3d(0, 0, -1)};
  for (int i = 0; i < 3; ++i) Feed(NextScan());
  base::HallScan scan = NextScan();
  scan.saturated_mask = 0xfff;
  Feed(scan);
  EXPECT_EQ(tool.limits & (base::kToolSensorSaturated | base::kToolFewReadings),
            base::kToolSensorSaturated | base::kToolFewReadings);
}

// Nothing that chi2 contradicts passes for a pose, and no pose is shown 20 ms after the last one that fitted.
TEST_F(TrackerDrift, ContradictoryReadingsReportThePenAbsent) {
  const auto second_magnet = [this](base::HallScan& scan) {
    const base::HallScan other =
        support::MakeScan(world, {{-0.05, 0.05, 0.05}, Vector3d(0, 1, -1).normalized()}, t_ns, rng);
    for (std::size_t i = 0; i < kSensors; ++i) {
      base::Vec3& B = scan.field_sensor_T[i];
      const base::Vec3& C = other.field_sensor_T[i];
      B = {B.x + C.x, B.y + C.y, B.z + C.z};
    }
  };
  const auto swapped = [](base::HallScan& scan) { std::swap(scan.field_sensor_T[1], scan.field_sensor_T[6]); };
  const auto gauss = [](base::HallScan& scan) {
    for (base::Vec3& B : scan.field_sensor_T) B = {1e4 * B.x, 1e4 * B.y, 1e4 * B.z};
  };
  const auto gone = [](base::HallScan& scan) { scan.field_sensor_T.fill({3e-7, -2e-7, 4e-7}); };
  const std::function<void(base::HallScan&)> faults[] = {second_magnet, swapped, gauss, gone};
  for (std::size_t f = 0; f < std::size(faults); ++f) {
    SCOPED_TRACE(f);
    state = {};
    for (int i = 0; i < 50; ++i) Feed(NextScan());
    ASSERT_EQ(tool.status, TrackingStatus::kTracking);
    for (int i = 0; i < 20; ++i) {
      base::HallScan scan = NextScan();
      faults[f](scan);
      Feed(scan);
      ASSERT_NE(tool.status, TrackingStatus::kTracking);
      if (f < 2) {
        EXPECT_EQ(tool.limits & base::kToolContradicted, base::kToolContradicted);
      }
    }
    EXPECT_EQ(tool.status, TrackingStatus::kAbsent);
    EXPECT_EQ(tool.velocity_base_m_s, base::Vec3{});
    for (int i = 0; i < 10; ++i) Feed(NextScan());
    EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  }
}

}  // namespace test_tracker_drift
}  // namespace omni::tracker
