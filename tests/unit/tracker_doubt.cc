// What the tracker does when its model of the room, of one sensor or of the whole base is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "service/loop/probe/alloc_probe.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/nominal_device.h"
#include "tests/support/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_doubt {

using base::TrackingStatus;
using Eigen::Vector3d;

base::Calibration Exact() { return magnetics::NominalCalibration(support::NominalDevice()); }

class TrackerDoubt : public testing::TestWithParam<std::uint64_t> {
 protected:
  Config config = MakeConfig(Exact());
  Model world = config.model;  // what the readings are made with
  Vector3d ambient_base_T = Vector3d::Zero();
  std::function<void(base::HallScan&)> fault = [](base::HallScan&) {};
  State state;
  base::ToolState tool;
  support::Rng rng{GetParam()};
  Pose pose;
  int tick = 0;

  // Circles over the base, tilting.
  void Move() {
    const double t_s = 1e-3 * tick;
    pose.position_base_m = {0.02 * std::cos(4 * t_s), 0.02 * std::sin(4 * t_s), 0.060 + 0.01 * std::sin(3 * t_s)};
    pose.axis_base = Vector3d(0.4 * std::sin(2 * t_s), 0.4 * std::cos(2.5 * t_s), -1).normalized();
  }
  base::HallScan NextScan() {
    const std::int64_t t_ns = 1'000'000'000 + 1'000'000LL * ++tick;
    Move();
    base::HallScan scan = support::MakeScan(world, pose, t_ns, rng, {1, {}});
    scan.coil_current_A = {};
    for (std::size_t i = 0; i < kSensors; ++i) {
      const auto axis = [&](std::size_t row) {
        double sum_T = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          sum_T += world.gain_sensor_base[3 * row + c][i] * ambient_base_T[static_cast<Eigen::Index>(c)];
        }
        return sum_T;
      };
      base::Vec3& B = scan.field_sensor_T[i];
      B = {B.x + axis(0), B.y + axis(1), B.z + axis(2)};
    }
    fault(scan);
    return scan;
  }
  // Without allocating. True: tracked.
  bool Feed() {
    const base::HallScan scan = NextScan();
    const loop::AllocProbe probe;
    Update(config, scan, state, tool);
    EXPECT_EQ(probe.count(), 0u);
    return tool.status == TrackingStatus::kTracking;
  }
  double Error_m() const { return (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm(); }
  double Sigma_m() const { return std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]); }
  Vector3d Direction() { return support::RandomUnit(rng); }
  double Normal() { return std::normal_distribution<double>()(rng); }

  struct Outcome {
    int lost = 0;    // the last tick of the run that had no pose, from 1; 0: none
    int silent = 0;  // errors beyond five standard deviations
    double mean_m = 0;
  };
  Outcome Run(int ticks) {
    Outcome outcome;
    int tracked = 0;
    for (int i = 1; i <= ticks; ++i) {
      if (!Feed()) {
        outcome.lost = i;
        continue;
      }
      ++tracked;
      outcome.mean_m += Error_m();
      outcome.silent += Error_m() > 5 * Sigma_m() ? 1 : 0;
    }
    outcome.mean_m /= std::max(1, tracked);
    return outcome;
  }
};
INSTANTIATE_TEST_SUITE_P(Seeds, TrackerDoubt, testing::Values(1U, 2U, 3U));

TEST_P(TrackerDoubt, AFieldThatJumpsIsFollowedInThatScan) {
  const double undisturbed_m = Run(2000).mean_m;
  for (const double size_T : {5e-6, 20e-6, 60e-6}) {
    SCOPED_TRACE(size_T);
    ambient_base_T += size_T * Direction();
    const Outcome after = Run(1000);
    EXPECT_LE(after.lost, 20);
    EXPECT_EQ(after.silent, 0);
    EXPECT_LT(after.mean_m, 1.3 * undisturbed_m);
  }
}

TEST_P(TrackerDoubt, TheEarthsFieldMayComeUnannounced) {
  ambient_base_T = 5e-5 * Direction();
  EXPECT_LE(Run(1000).lost, 50);
  EXPECT_EQ(Run(1000).lost, 0);
}

TEST_P(TrackerDoubt, ABaseThatIsTurnedKeepsThePen) {
  const double undisturbed_m = Run(2000).mean_m;
  const Vector3d earth_T = 5e-5 * Direction();
  int lost = 0;
  double mean_m = 0;
  for (int i = 0; i < 4000; ++i) {
    const double angle = 90 * std::numbers::pi / 180 * 1e-3 * i;
    ambient_base_T = Eigen::AngleAxisd(angle, Vector3d::UnitZ()) * earth_T - earth_T;
    lost += Feed() ? 0 : 1;
    mean_m += Error_m() / 4000;
  }
  EXPECT_LE(lost, 20);
  EXPECT_LT(mean_m, 2 * undisturbed_m);
}

struct Fault {
  const char* name;
  std::function<void(base::Vec3&)> change;
};

TEST_P(TrackerDoubt, ASensorThatIsWrongIsLeftOutUntilItIsRightAgain) {
  const double undisturbed_m = Run(2000).mean_m;
  base::Vec3 held{};
  const Fault faults[] = {
      {"stuck", [&](base::Vec3& B) { B = held; }},
      {"huge",
       [](base::Vec3& B) {
         B = {1e-3, 1e-3, 1e-3};
       }},
      {"ten per cent",
       [](base::Vec3& B) {
         B = {1.1 * B.x, 1.1 * B.y, 1.1 * B.z};
       }},
  };
  for (const Fault& wrong : faults) {
    SCOPED_TRACE(wrong.name);
    const int sensor = static_cast<int>(GetParam()) % kSensors;
    held = NextScan().field_sensor_T[static_cast<std::size_t>(sensor)];
    fault = [&](base::HallScan& scan) { wrong.change(scan.field_sensor_T[static_cast<std::size_t>(sensor)]); };
    const Outcome at_first = Run(1000);
    EXPECT_LE(at_first.lost, 400);  // a stuck sensor is right for a while
    const Outcome later = Run(1000);
    EXPECT_EQ(later.lost, 0);
    EXPECT_EQ(later.silent, 0);
    EXPECT_LT(later.mean_m, 2 * undisturbed_m);
    EXPECT_EQ(state.doubt.left_out, sensor);
    fault = [](base::HallScan&) {};
    const Outcome right = Run(6000);
    EXPECT_EQ(right.lost, 0);
    EXPECT_EQ(state.doubt.left_out, -1);
    EXPECT_LT(right.mean_m, 1.5 * undisturbed_m);
  }
}

// A fifth of what a workshop leaves, which the calibration says nothing of.
TEST_P(TrackerDoubt, ACalibrationThatIsWorseThanItSaysIsTrackedAndToldOf) {
  base::Calibration built = Exact();
  for (base::SensorCalibration& sensor : built.sensors) {
    base::Vec3& p = sensor.position_base_m;
    p = {p.x + 2e-4 * Normal(), p.y + 2e-4 * Normal(), p.z + 2e-4 * Normal()};
    for (double& gain : sensor.gain_sensor_base) gain *= 1 + 0.003 * Normal();
  }
  world = MakeModel(built);
  Run(1000);
  const Outcome outcome = Run(4000);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.mean_m, 1.5e-3);
  EXPECT_GT(state.doubt.model_error, 2e-3);
}

TEST_P(TrackerDoubt, ThreeSensorsAreTooFew) {
  Run(1000);
  fault = [](base::HallScan& scan) {
    for (std::size_t i = 0; i < 5; ++i) scan.age_ns[i] = 1'000'000'000;
  };
  const Outcome outcome = Run(100);
  EXPECT_EQ(outcome.lost, 100);
  EXPECT_EQ(tool.status, TrackingStatus::kAbsent);
}

}  // namespace test_tracker_doubt
}  // namespace omni::tracker
