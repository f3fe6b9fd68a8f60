// Learning while no pen is near: the uniform field and the sensors' zeros, never a magnet's field.
#include <gtest/gtest.h>

#include <cmath>

#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_away {

using Eigen::Vector3d;

constexpr double kStep_s = 0.016;  // omnid without a client

class TrackerAway : public testing::TestWithParam<std::uint64_t> {
 protected:
  Config config = MakeConfig(magnetics::NominalCalibration(support::NominalDevice()));
  support::Rng rng{GetParam()};
  Vector3d ambient_base_T = Vector3d::Zero();
  ReadingLanes zero_T{};
  double pen_away_m = 0;  // 0: there is none
  Vector3d pen_direction = support::RandomUnit(rng), pen_axis = support::RandomUnit(rng);
  State state;
  base::ToolState tool;
  std::int64_t t_ns = 1'000'000'000;

  double Normal(double sigma) { return std::normal_distribution<double>(0, sigma)(rng); }
  void DriftZeros(double sigma_T) {
    for (double& value : zero_T) value += Normal(sigma_T);
  }
  void Feed() {
    t_ns += static_cast<std::int64_t>(1e9 * kStep_s);
    const Pose pose{pen_away_m > 0 ? Vector3d(pen_away_m * pen_direction) : Vector3d(0, 0, 1e3), pen_axis};
    base::HallScan scan = support::MakeScan(config.model, pose, t_ns, rng, {1, {}});
    scan.coil_current_A = {};
    for (std::size_t i = 0; i < kSensors; ++i) {
      const auto axis = [&](std::size_t row) {
        double sum_T = zero_T[kSensors * row + i];
        for (std::size_t c = 0; c < 3; ++c) {
          sum_T += config.model.gain_sensor_base[3 * row + c][i] * ambient_base_T[static_cast<Eigen::Index>(c)];
        }
        return sum_T;
      };
      base::Vec3& B = scan.field_sensor_T[i];
      B = {B.x + axis(0), B.y + axis(1), B.z + axis(2)};
    }
    Update(config, scan, state, tool);
    EXPECT_NE(tool.status, base::TrackingStatus::kTracking);
  }
  void Run(double seconds) {
    for (double s = 0; s < seconds; s += kStep_s) Feed();
  }
  double AmbientError_T() const {
    return (Vector3d(state.room.drift.mean[3], state.room.drift.mean[4], state.room.drift.mean[5]) - ambient_base_T)
        .norm();
  }
  double LearntZeros_T() const {
    double sum = 0;
    for (const double value : state.room.away.zero_T) sum += value * value;
    return std::sqrt(sum / kReadings);
  }
  // Error of the readings beside the uniform part and that of the core's shape, which other states hold.
  double Field_T() const { return tool.field_rms_T; }
};
INSTANTIATE_TEST_SUITE_P(Seeds, TrackerAway, testing::Values(1U, 2U, 3U, 4U));

TEST_P(TrackerAway, UniformAmbientFieldIsFollowed) {
  for (const double size_T : {20e-6, 60e-6}) {
    ambient_base_T += size_T * support::RandomUnit(rng);
    Run(3);
    EXPECT_LT(AmbientError_T(), 5e-7);
    EXPECT_LT(LearntZeros_T(), 4e-7);
    EXPECT_EQ(tool.limits & base::kToolContradicted, 0U);
  }
}

TEST_P(TrackerAway, DriftingSensorZerosAreSubtracted) {
  DriftZeros(5e-6);
  Run(10);
  EXPECT_TRUE(state.room.away.learnt);
  EXPECT_LT(Field_T(), 2.5e-6) << "noise of three axes, and what is left";
  for (int minute = 0; minute < 3; ++minute) {
    DriftZeros(2e-7);
    Run(20);
  }
  EXPECT_LT(Field_T(), 2.5e-6);
}

// Brought, and left there: its field goes into neither the zeros nor the ambient field.
TEST_P(TrackerAway, ApproachingMagnetIsNotLearntAsSensorZero) {
  ambient_base_T = 20e-6 * support::RandomUnit(rng);
  Run(5);
  const ReadingLanes before_T = state.room.away.zero_T;
  for (const double away_m : {0.6, 0.5, 0.4, 0.3}) {
    SCOPED_TRACE(away_m);
    pen_away_m = away_m;
    Run(20);
    double most_T = 0;
    for (std::size_t a = 0; a < kReadings; ++a) {
      most_T = std::max(most_T, std::abs(state.room.away.zero_T[a] - before_T[a]));
    }
    EXPECT_LT(most_T, 1e-7);
    EXPECT_LT(AmbientError_T(), 1e-6);
  }
}

// It was there before the first scan, and zeros might have drifted as much.
TEST_P(TrackerAway, MagnetPresentFromTheStartIsNotLearntAsSensorZero) {
  for (const double away_m : {0.6, 0.45, 0.3}) {
    SCOPED_TRACE(away_m);
    pen_away_m = away_m;
    state = {};
    Run(20);
    EXPECT_FALSE(state.room.away.learnt);
  }
}

}  // namespace test_tracker_away
}  // namespace omni::tracker
