// What the tracker does when its model of the room, of one sensor or of the whole base is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_doubt {

using base::TrackingStatus;
using Eigen::Vector3d;

base::Calibration Exact() { return magnetics::NominalCalibration(support::NominalDevice()); }

class TrackerDoubt : public testing::TestWithParam<std::uint64_t> {
 protected:
  base::DeviceGeometry device = support::NominalDevice();
  Config config = MakeConfig(Exact());
  Model world = config.model;  // what the readings are made with
  Vector3d ambient_base_T = Vector3d::Zero();
  double other_pen_away_m = 0;  // 0: there is none
  Vector3d other_pen_direction = Vector3d::UnitX(), other_pen_Am2 = Vector3d::Zero();
  std::function<void(base::HallScan&)> fault = [](base::HallScan&) {};
  State state;
  base::ToolState tool;
  support::Rng rng{GetParam()};
  Pose pose;
  int tick = 0;
  bool pen_is_there = true, pen_rests = false;

  // Circles over the base, tilting.
  void Move() {
    if (pen_rests) return;
    const double t_s = 1e-3 * tick;
    pose.position_base_m = {0.02 * std::cos(4 * t_s), 0.02 * std::sin(4 * t_s), 0.060 + 0.01 * std::sin(3 * t_s)};
    pose.axis_base = Vector3d(0.4 * std::sin(2 * t_s), 0.4 * std::cos(2.5 * t_s), -1).normalized();
  }
  base::HallScan NextScan() {
    const std::int64_t t_ns = 1'000'000'000 + 1'000'000LL * ++tick;
    Move();
    const Pose far{{0, 0, 1e3}, Vector3d::UnitZ()};
    base::HallScan scan = support::MakeScan(world, pen_is_there ? pose : far, t_ns, rng, {1, {}});
    scan.coil_current_A = {};
    for (std::size_t i = 0; i < kSensors; ++i) {
      Vector3d field_T = ambient_base_T;
      if (other_pen_away_m > 0) {
        const Vector3d from = base::ToEigen(device.sensors[i].position_base_m) - other_pen_away_m * other_pen_direction;
        field_T += magnetics::DipoleField(other_pen_Am2, from);
      }
      support::AddField(world, i, field_T, scan);
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
  // From one distance to another in a second. Returns how many poses were silently wrong.
  int CarryOtherPen(double from_m, double to_m) {
    int silent = 0;
    for (int i = 1; i <= 1000; ++i) {
      other_pen_away_m = from_m + 1e-3 * i * (to_m - from_m);
      silent += Feed() && Error_m() > 5 * Sigma_m() ? 1 : 0;
    }
    return silent;
  }
  void ExpectOtherPenFound(double relative) const {
    ASSERT_NE(state.room.stray.dipole.followed(), nullptr);
    const Eigen::Map<const Vector3d> at_m(state.room.stray.dipole.parameters.data()), moment_Am2(at_m.data() + 3);
    const Vector3d there_m = other_pen_away_m * other_pen_direction;
    EXPECT_LT((at_m - there_m).norm(), relative * there_m.norm());
    EXPECT_LT((moment_Am2 - other_pen_Am2).norm(), 3 * relative * other_pen_Am2.norm());
  }
  void DrawOtherPen() {
    const double angle = std::uniform_real_distribution(0.0, 2 * std::numbers::pi)(rng);
    other_pen_direction = {std::cos(angle), std::sin(angle), 0};
    other_pen_Am2 = world.moment_Am2 * Direction();
  }
  double Error_m() const { return (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm(); }
  double Sigma_m() const { return std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]); }
  static void Scale(double gain, base::Vec3& B) { B = {gain * B.x, gain * B.y, gain * B.z}; }
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

TEST_P(TrackerDoubt, AmbientFieldJumpIsFollowedWithinTwentyScans) {
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

// The field jumps between the samples of one scan, which fits nothing: once a second, while a magnet is searched for.
// Trials in one such scan are no evidence in the next.
TEST_P(TrackerDoubt, FieldJumpsWithinAScanDoNotCreateAStrayMagnet) {
  for (int i = 0; i < 500; ++i) Feed();
  for (int jump = 0; jump < 6; ++jump) {
    if (!state.room.stray.on) StartStray(config.stray, config.model, state.room.stray);
    const Vector3d before_T = ambient_base_T;
    ambient_base_T = jump % 2 == 0 ? Vector3d(6e-5 * Direction()) : Vector3d::Zero();
    fault = [&](base::HallScan& scan) {  // the first half was sampled before
      for (std::size_t i = 0; i < kSensors / 2; ++i) {
        support::AddField(world, i, before_T - ambient_base_T, scan);
      }
    };
    Feed();
    fault = [](base::HallScan&) {};
    int lost = 0;
    for (int i = 0; i < 1000; ++i) lost += Feed() ? 0 : 1;
    EXPECT_LE(lost, 1) << jump;
    EXPECT_FALSE(state.room.stray.believed) << jump;
    EXPECT_LT(Sigma_m(), 1e-3) << jump;
  }
}

TEST_P(TrackerDoubt, TracksAfterUnexpectedEarthFieldStep) {
  ambient_base_T = 5e-5 * Direction();
  EXPECT_LE(Run(1000).lost, 50);
  EXPECT_EQ(Run(1000).lost, 0);
}

TEST_P(TrackerDoubt, KeepsTrackingWhileTheBaseTurns) {
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

TEST_P(TrackerDoubt, FaultySensorIsExcludedUntilItRecovers) {
  const double undisturbed_m = Run(2000).mean_m;
  base::Vec3 held{};
  const Fault faults[] = {
      {"stuck", [&](base::Vec3& B) { B = held; }},
      {"huge",
       [](base::Vec3& B) {
         B = {1e-3, 1e-3, 1e-3};
       }},
      {"ten per cent", [](base::Vec3& B) { Scale(1.1, B); }},
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
    EXPECT_EQ(state.room.doubt.left_out, sensor);
    fault = [](base::HallScan&) {};
    const Outcome right = Run(6000);
    EXPECT_EQ(right.lost, 0);
    EXPECT_EQ(state.room.doubt.left_out, -1);
    EXPECT_LT(right.mean_m, 1.5 * undisturbed_m);
  }
}

// The effect of a gain error follows the pen's field at that sensor; that of a magnet does not.
TEST_P(TrackerDoubt, SmallGainErrorIsNotTakenForAMagnet) {
  const double undisturbed_m = Run(2000).mean_m;
  const auto sensor = static_cast<std::size_t>(GetParam() + 2) % kSensors;
  for (const double gain : {1.015, 0.98, 1.03}) {
    SCOPED_TRACE(gain);
    fault = [&](base::HallScan& scan) { Scale(gain, scan.field_sensor_T[sensor]); };
    for (int i = 0; i < 3000; ++i) {
      const bool tracked = Feed();
      EXPECT_TRUE(tracked || i < 20);
      EXPECT_TRUE(!tracked || Error_m() < 5 * Sigma_m());
      EXPECT_EQ(state.room.stray.dipole.followed(), nullptr);
    }
    EXPECT_EQ(state.room.doubt.left_out, static_cast<int>(sensor));
    EXPECT_LT(Run(2000).mean_m, 1.5 * undisturbed_m);
    fault = [](base::HallScan&) {};
    Run(15000);
    EXPECT_EQ(state.room.doubt.left_out, -1);
  }
}

// A sensor left out is not readmitted because another one is a little wrong.
TEST_P(TrackerDoubt, SmallGainErrorDoesNotReadmitAStuckSensor) {
  Run(2000);
  const auto stuck = static_cast<std::size_t>(GetParam()) % kSensors, wrong = (stuck + 4) % kSensors;
  const base::Vec3 held = NextScan().field_sensor_T[stuck];
  double gain = 1;
  fault = [&](base::HallScan& scan) {
    scan.field_sensor_T[stuck] = held;
    Scale(gain, scan.field_sensor_T[wrong]);
  };
  Run(500);
  ASSERT_EQ(state.room.doubt.left_out, static_cast<int>(stuck));
  gain = 1.02;
  for (int i = 0; i < 5000; ++i) {
    const bool tracked = Feed();
    EXPECT_EQ(state.room.doubt.left_out, static_cast<int>(stuck));
    EXPECT_TRUE(!tracked || Error_m() < 5 * Sigma_m());
  }
}

TEST_P(TrackerDoubt, StuckSensorIsExcludedWithoutLosingThePose) {
  Run(1000);
  const auto sensor = static_cast<std::size_t>(GetParam()) % kSensors;
  const base::Vec3 held = NextScan().field_sensor_T[sensor];
  fault = [&](base::HallScan& scan) { scan.field_sensor_T[sensor] = held; };
  const Outcome outcome = Run(1000);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_EQ(outcome.silent, 0);
  EXPECT_EQ(state.room.doubt.left_out, static_cast<int>(sensor));
}

// The stamp advances, but nothing is measured: no single sensor is to blame, and no pose is accepted.
TEST_P(TrackerDoubt, FrozenReadingsOfAllSensorsYieldNoPose) {
  Run(1000);
  const base::HallScan held = NextScan();
  fault = [&](base::HallScan& scan) { scan.field_sensor_T = held.field_sensor_T; };
  const Outcome frozen = Run(config.doubt.frozen_scans + config.lost_after_scans);
  EXPECT_GT(frozen.lost, 0);
  EXPECT_EQ(tool.status, TrackingStatus::kAbsent);
  EXPECT_NE(tool.limits & base::kToolFrozen, 0U);
  EXPECT_EQ(tool.sensors_left_out, 0U);
  fault = [](base::HallScan&) {};
  EXPECT_LE(Run(100).lost, 20);
  EXPECT_EQ(tool.limits & base::kToolFrozen, 0U);
}

TEST_P(TrackerDoubt, ToolStateReportsAmbientFieldAndExcludedSensors) {
  Run(1000);
  EXPECT_EQ(tool.sensors_left_out, 0U);
  EXPECT_EQ(tool.stray_rms_T, 0);
  ambient_base_T = 2e-5 * Direction();
  Run(500);
  EXPECT_NEAR(base::ToEigen(tool.ambient_base_T).norm(), 2e-5, 2e-6);
  const int sensor = static_cast<int>(GetParam());
  fault = [&](base::HallScan& scan) { Scale(1.1, scan.field_sensor_T[static_cast<std::size_t>(sensor)]); };
  Run(1000);
  EXPECT_EQ(tool.sensors_left_out, 1U << sensor);
  EXPECT_EQ(tool.sensors_disagree, 1U << sensor);
}

TEST_P(TrackerDoubt, NoStrayMagnetIsReportedWithoutOne) {
  Run(5000);
  ambient_base_T = 2e-5 * Direction();
  Run(5000);
  EXPECT_FALSE(state.room.stray.believed);
}

TEST_P(TrackerDoubt, NearbyPenIsEstimatedAndSubtracted) {
  for (const double away_m : {0.35, 0.3}) {
    SCOPED_TRACE(away_m);
    const double undisturbed_m = Run(2000).mean_m;
    DrawOtherPen();
    const auto beside_it = [&](bool learns) {
      config.stray.enabled = learns;
      CarryOtherPen(1, away_m);
      Run(1000);
      return Run(4000);
    };
    const State before = state;
    const support::Rng drawn = rng;
    const int started = tick;
    const Outcome unlearnt = beside_it(false);
    state = before, rng = drawn, tick = started;
    const Outcome learnt = beside_it(true);
    EXPECT_TRUE(state.room.stray.believed);
    EXPECT_EQ(learnt.lost, 0);
    EXPECT_EQ(learnt.silent, 0);
    EXPECT_LT(learnt.mean_m, 4 * undisturbed_m);
    ExpectOtherPenFound(0.15);
    EXPECT_TRUE(unlearnt.lost > 0 || learnt.mean_m < 0.5 * unlearnt.mean_m);
    CarryOtherPen(away_m, 1);
    other_pen_away_m = 0;
    Run(6000);
    const Outcome gone = Run(1000);
    EXPECT_EQ(gone.lost, 0);
    EXPECT_EQ(gone.silent, 0);
    EXPECT_LT(gone.mean_m, 3 * undisturbed_m);
  }
}

// One place shows little; meanwhile the pose's uncertainty is reported.
TEST_P(TrackerDoubt, PenPlacedBesideARestingPenIsFound) {
  Run(2000);
  DrawOtherPen();
  pen_rests = true;
  EXPECT_LE(CarryOtherPen(1, 0.3), 20);
  EXPECT_EQ(Run(1000).silent, 0);
  pen_rests = false;
  Run(3000);
  const Outcome found = Run(1000);
  EXPECT_EQ(found.lost, 0);
  EXPECT_EQ(found.silent, 0);
  EXPECT_LT(found.mean_m, 1e-3);
  ExpectOtherPenFound(0.1);
  EXPECT_EQ(state.room.doubt.left_out, -1);
}

// A magnet explains other readings than those of a sensor that was left out before it came.
TEST_P(TrackerDoubt, NearbyPenDoesNotReadmitAFaultySensor) {
  base::Vec3 held{};
  const Fault faults[] = {
      {"ten per cent", [](base::Vec3& B) { Scale(1.1, B); }},
      {"stuck", [&](base::Vec3& B) { B = held; }},
  };
  const auto sensor = static_cast<std::size_t>(GetParam()) % kSensors;
  for (const Fault& wrong : faults) {
    SCOPED_TRACE(wrong.name);
    state = {};
    Run(2000);
    held = NextScan().field_sensor_T[sensor];
    fault = [&](base::HallScan& scan) { wrong.change(scan.field_sensor_T[sensor]); };
    Run(3000);
    ASSERT_EQ(state.room.doubt.left_out, static_cast<int>(sensor));
    DrawOtherPen();
    EXPECT_LE(CarryOtherPen(1, 0.3), 20);
    for (int i = 0; i < 5000; ++i) {
      EXPECT_TRUE(Feed());
      EXPECT_LT(Error_m(), 5 * Sigma_m());
      EXPECT_EQ(state.room.doubt.left_out, static_cast<int>(sensor));
    }
    EXPECT_NE(state.room.stray.dipole.followed(), nullptr);
    other_pen_away_m = 0;
    fault = [](base::HallScan&) {};
  }
}

// And the other way round: a sensor that fails is not explained by a sudden change of the magnet.
TEST_P(TrackerDoubt, FaultySensorIsExcludedBesideANearbyPen) {
  for (std::size_t sensor = 0; sensor < kSensors; ++sensor) {
    SCOPED_TRACE(sensor);
    state = {};
    Run(2000);
    DrawOtherPen();
    CarryOtherPen(1, 0.3);
    Run(3000);
    fault = [&](base::HallScan& scan) { Scale(1.1, scan.field_sensor_T[sensor]); };
    const Outcome outcome = Run(3000);
    EXPECT_LT(outcome.lost, 20);
    EXPECT_EQ(outcome.silent, 0);
    EXPECT_EQ(state.room.doubt.left_out, static_cast<int>(sensor));
    other_pen_away_m = 0;
    fault = [](base::HallScan&) {};
  }
}

// As after a search step that went too far: its field is larger than in any room, and nothing else is wrong.
TEST_P(TrackerDoubt, ImplausibleStrayMagnetIsSearchedForAgain) {
  Run(2000);
  DrawOtherPen();
  CarryOtherPen(1, 0.3);
  Run(3000);
  ASSERT_NE(state.room.stray.dipole.followed(), nullptr);
  for (std::size_t k = 0; k < 3; ++k) {
    state.room.stray.dipole.parameters[k] *= 0.4;
    state.room.stray.dipole.covariance[7 * k] = 1e-6;
  }
  EXPECT_LE(Run(100).lost, 0);
  EXPECT_LE(Run(3000).lost, 0);
  EXPECT_EQ(Run(1000).silent, 0);
  ExpectOtherPenFound(0.15);
}

// Tracking an imaginary pen would be worse than none.
TEST_P(TrackerDoubt, NearbyMagnetIsNotTrackedAsThePen) {
  pen_is_there = false;
  for (const double away_m : {0.5, 0.3}) {
    SCOPED_TRACE(away_m);
    DrawOtherPen();
    other_pen_away_m = away_m;
    EXPECT_EQ(Run(2000).silent, 0);
    EXPECT_NE(tool.status, TrackingStatus::kTracking);
  }
}

// A spare pen that lies there when omnid starts, before any pose is known. Without a search for both, none of these is
// found at 200 mm, and one of ten at 300. Seldom another place fits as well at first.
TEST_P(TrackerDoubt, TracksWithASecondPenPresentFromTheStart) {
  int silent = 0, ticks = 0;
  for (const double away_m : {0.2, 0.25, 0.3}) {
    SCOPED_TRACE(away_m);
    int as_without = 0;
    for (int trial = 0; trial < 10; ++trial) {
      state = {};
      DrawOtherPen();
      other_pen_away_m = away_m;
      silent += Run(2000).silent;
      const Outcome after = Run(3000);
      EXPECT_EQ(after.lost, 0);
      silent += after.silent;
      as_without += after.mean_m < 0.6e-3 ? 1 : 0;
      ticks += 5000;
    }
    EXPECT_GE(as_without, 6);
  }
  EXPECT_LT(silent, 0.002 * ticks);
}

// Two magnets are no pen either, nor is one beside a sensor that is wrong.
TEST_P(TrackerDoubt, MagnetPairOrFaultySensorIsNotTrackedAsThePen) {
  pen_is_there = false;
  for (int trial = 0; trial < 4; ++trial) {
    SCOPED_TRACE(trial);
    state = {};
    DrawOtherPen();
    other_pen_away_m = 0.3;
    const Vector3d at_m = 0.28 * Direction(), moment_Am2 = world.moment_Am2 * Direction();
    const bool gain_is_wrong = trial % 2 == 1;
    fault = [=, this](base::HallScan& scan) {
      if (gain_is_wrong) return Scale(1.1, scan.field_sensor_T[3]);
      for (std::size_t i = 0; i < kSensors; ++i) {
        const Vector3d from_m = base::ToEigen(device.sensors[i].position_base_m) - at_m;
        support::AddField(world, i, magnetics::DipoleField(moment_Am2, from_m), scan);
      }
    };
    for (int n = 0; n < 3000; ++n) EXPECT_FALSE(Feed());
  }
}

// A fifth of an uncalibrated base's errors, which the calibration does not state.
TEST_P(TrackerDoubt, TracksAndReportsAnOverconfidentCalibration) {
  base::Calibration built = Exact();
  for (base::SensorCalibration& sensor : built.sensors) {
    base::Vec3& p = sensor.position_base_m;
    p = {p.x + 2e-4 * Normal(), p.y + 2e-4 * Normal(), p.z + 2e-4 * Normal()};
    for (double& gain : sensor.gain_sensor_base) gain *= 1 + 0.003 * Normal();
  }
  world = MakeModel(built);
  const Outcome outcome = Run(4000);
  EXPECT_EQ(outcome.lost, 0);
  EXPECT_LT(outcome.mean_m, 1.5e-3);
  EXPECT_EQ(outcome.silent, 0);
  EXPECT_TRUE(state.room.doubt.model_error > 2e-3 || state.room.stray.believed);
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
