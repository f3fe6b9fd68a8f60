// A pen that lies still: its pose does not creep though its calibration is not exact, and a room's field is followed.
#include <gtest/gtest.h>

#include <cmath>

#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_still {

using base::TrackingStatus;
using Eigen::Vector3d;

class TrackerStill : public testing::Test {
 protected:
  TrackerStill() {
    // The calibration's remaining error: each gain is .2 % off.
    for (base::SensorCalibration& sensor : true_base.sensors) {
      for (double& gain : sensor.gain_sensor_base) gain *= 1 + 2e-3 * normal(rng);
    }
    world = MakeModel(true_base);
  }

  base::HallScan NextScan() {
    t_ns += 1'000'000;
    base::HallScan scan = support::MakeScan(world, pose, t_ns, rng, {.noise_scale = 1});
    scan.coil_current_A = {};
    scan.sequence = static_cast<std::uint64_t>(t_ns / 1'000'000);
    for (std::size_t i = 0; i < kSensors; ++i) support::AddField(world, i, ambient_base_T, scan);
    return scan;
  }
  void Move(double seconds) {
    for (int n = 0; n < 1000 * seconds; ++n) {
      const double t_s = 1e-9 * static_cast<double>(t_ns);
      pose.position_base_m = {0.03 * std::cos(4 * t_s), 0.03 * std::sin(4 * t_s), 0.07 + 0.01 * std::sin(3 * t_s)};
      pose.axis_base = Vector3d(0.4 * std::sin(2 * t_s), 0.4 * std::cos(2.5 * t_s), -1).normalized();
      Update(config, NextScan(), state, tool);
    }
  }
  // Mean pose over so many seconds in which nothing changes but the field, at this rate.
  Vector3d Lie(double seconds, const Vector3d& rate_T_s = Vector3d::Zero()) {
    Vector3d sum = Vector3d::Zero();
    Update(config, NextScan(), state, tool);  // put down there
    Update(config, NextScan(), state, tool);
    const int scans = static_cast<int>(1000 * seconds);
    for (int n = 0; n < scans; ++n) {
      ambient_base_T += 1e-3 * rate_T_s;
      Update(config, NextScan(), state, tool);
      EXPECT_EQ(tool.status, TrackingStatus::kTracking);
      sum += base::ToEigen(tool.position_base_m);
    }
    return sum / scans;
  }

  support::Rng rng{31};
  std::normal_distribution<double> normal;
  base::Calibration calibration = magnetics::NominalCalibration(support::NominalDevice());
  base::Calibration true_base = calibration;
  Config config = MakeConfig(calibration);
  Model world;
  Vector3d ambient_base_T = Vector3d::Zero();
  Pose pose;
  State state;
  base::ToolState tool;
  std::int64_t t_ns = 1'000'000'000;
};

TEST_F(TrackerStill, EstimateOfARestingPenDoesNotCreep) {
  Move(5);
  pose = {{0.02, 0.01, 0.055}, Vector3d(0.2, 0.1, -1).normalized()};
  Lie(3);
  ASSERT_TRUE(state.room.drift.still.referenced);
  const Vector3d first_m = Lie(10);
  const DriftVector mean = state.room.drift.mean;
  Lie(40);
  EXPECT_LT((Lie(10) - first_m).norm(), 2e-5);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(state.room.drift.mean[k], mean[k], 2e-4);
}

TEST_F(TrackerStill, SlowAmbientChangeIsFollowedAtRest) {
  Move(5);
  pose = {{0.02, 0.01, 0.085}, Vector3d(0.2, 0.1, -1).normalized()};
  Lie(3);
  const Vector3d first_m = Lie(10);
  const auto before_T = AmbientField_T(state.room.drift);
  Lie(30, {5e-8, -3e-8, 2e-8});  // 1.5 uT in half a minute
  EXPECT_LT((Lie(10) - first_m).norm(), 2e-4);
  const auto after_T = AmbientField_T(state.room.drift);
  EXPECT_NEAR(after_T[0] - before_T[0], 1.5e-6, 2e-7);
}

// A magnet that warms by 2 K in five minutes loses .24 % of its moment: at 55 mm like moving .05 mm away.
TEST_F(TrackerStill, WarmingMagnetDoesNotMoveTheRestingPose) {
  Move(5);
  pose = {{0.02, 0.01, 0.055}, Vector3d(0.2, 0.1, -1).normalized()};
  Lie(3);
  const Vector3d first_m = Lie(10);
  const double moment_Am2 = true_base.moment_Am2;
  for (int second = 0; second < 300; second += 10) {
    true_base.moment_Am2 = moment_Am2 * (1 - 8e-6 * second);
    world = MakeModel(true_base);
    Lie(10);
  }
  EXPECT_LT((Lie(10) - first_m).norm(), 3e-5);
}

// Of 120,000 scans some are odd by chance. None of them is a movement.
TEST_F(TrackerStill, NoiseIsNotTakenForMovement) {
  Move(5);
  pose = {{0.02, 0.01, 0.09}, Vector3d(0.2, 0.1, -1).normalized()};
  Lie(3);
  ASSERT_TRUE(state.room.drift.still.referenced);
  const double still_s = state.room.drift.still.still_s;
  Lie(120);
  EXPECT_NEAR(state.room.drift.still.still_s, still_s + 120, 0.1);
}

// A drawer is opened. The model's error where the pen lies stays as it was.
TEST_F(TrackerStill, FieldJumpDoesNotMoveTheRestingPose) {
  Move(5);
  pose = {{0.02, 0.01, 0.055}, Vector3d(0.2, 0.1, -1).normalized()};
  Lie(3);
  const Vector3d first_m = Lie(10);
  for (const double size_T : {5e-6, -20e-6}) {
    ambient_base_T += Vector3d(size_T, size_T, -size_T);
    Lie(2);
    EXPECT_TRUE(state.room.drift.still.referenced);
    EXPECT_LT((Lie(5) - first_m).norm(), 3e-5);
  }
}

TEST_F(TrackerStill, MovingPenIsNoLongerStill) {
  Move(2);
  Lie(3);
  ASSERT_TRUE(state.room.drift.still.referenced);
  Move(0.2);
  EXPECT_FALSE(state.room.drift.still.referenced);
}

// Two scans at one instant, the first of those at rest.
TEST_F(TrackerStill, AcceptsScansWithoutElapsedTime) {
  const StillOptions options;
  const PenPlace pen{{0, 0, 0.055}, {0, 0, -1}, {}, 1e-4, 1e-3};
  StillPen still;
  for (const double dt_s : {0.001, 0.0, 0.0, 0.001}) {
    EXPECT_GE(ForgottenOf(options, dt_s, &pen, 0, still), 0);
    EXPECT_NEAR(still.place.position_base_m.z, 0.055, 1e-12);
  }
}

// The core's remanence becomes uncertain only once the pen moves.
TEST_F(TrackerStill, RestDoesNotShrinkTheCovariance) {
  Move(5);
  Lie(3);
  ASSERT_TRUE(state.room.drift.still.referenced);
  const DriftMatrix before = state.room.drift.covariance;
  Lie(20);
  for (std::size_t a = 0; a < kDriftStates; ++a) {
    const std::size_t e = a * (kDriftStates + 1);
    EXPECT_GE(state.room.drift.covariance[e], 0.99 * state.room.drift.still.reference_covariance[e]);
    EXPECT_LE(state.room.drift.covariance[e], 1.5 * before[e]);
  }
}

}  // namespace test_tracker_still
}  // namespace omni::tracker
