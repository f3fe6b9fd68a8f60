// Scenarios of the tracker: found, moving, lost, gone; and every kind of malformed scan.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"
#include "tests/support/same_bits.h"

namespace omni::tracker {
namespace test_tracker_update {

using base::TrackingStatus;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

bool IsFinite(const base::ToolState& tool) {
  bool finite = std::isfinite(tool.gap_m) && std::isfinite(tool.chi2);
  for (const base::Vec3& v :
       {tool.position_base_m, tool.axis_base, tool.velocity_base_m_s, tool.angular_velocity_base_rad_s,
        tool.device_point_base_m, tool.device_point_velocity_base_m_s}) {
    finite = finite && std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  }
  for (const double c : tool.covariance) finite = finite && std::isfinite(c);
  return finite && std::abs(base::ToEigen(tool.axis_base).norm() - 1) < 1e-9;
}

class TrackerUpdate : public testing::Test {
 protected:
  Config config = MakeConfig(magnetics::NominalCalibration(support::NominalDevice()));
  State state;
  base::ToolState tool;
  support::Rng rng{7};
  std::int64_t t_ns = 1'000'000'000;
  Pose pose{{0.01, -0.005, 0.055}, Vector3d(0.1, 0.2, -1).normalized()};
  double noise_scale = 1;
  std::array<double, 3> coil_current_A{};

  base::HallScan NextScan() {
    t_ns += 1'000'000;
    base::HallScan scan = support::MakeScan(config.model, pose, t_ns, rng, {noise_scale, coil_current_A});
    scan.sequence = static_cast<std::uint64_t>(t_ns / 1'000'000);
    return scan;
  }
  void Feed(const base::HallScan& scan) {
    Update(config, scan, state, tool);
    ASSERT_TRUE(IsFinite(tool));
    ASSERT_EQ(tool.t_ns, scan.t_ns);
  }
  void Run(int scans) {
    for (int i = 0; i < scans; ++i) Feed(NextScan());
  }
  double Error_m() const { return (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm(); }
};

TEST_F(TrackerUpdate, FirstScanYieldsAPose) {
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_TRUE(tool.ever_tracked);
  EXPECT_EQ(tool.dof, 19);
  EXPECT_LT(Error_m(), 1e-3);
  EXPECT_GT(base::ToEigen(tool.axis_base).dot(pose.axis_base), std::cos(0.02));
  EXPECT_NEAR(tool.device_point_base_m.z, tool.position_base_m.z + 0.005 * tool.axis_base.z, 1e-12);
}

// Sensors slower than the tick: the scan in between is the previous one again.
TEST_F(TrackerUpdate, RepeatedTimestampKeepsStateAndSetsRepeatedFlag) {
  Run(50);
  for (int i = 0; i < 20; ++i) {
    const base::HallScan scan = NextScan();
    Feed(scan);
    const base::ToolState first = tool;
    for (int again = 0; again < 6; ++again) {
      Feed(scan);
      ASSERT_EQ(tool.limits, first.limits | base::kToolRepeated);
      tool.limits = first.limits;
      ASSERT_TRUE(support::SameBits(tool, first));
    }
    t_ns += 6'000'000;
  }
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
}

// A device whose clock stops while its sensors go on: no old pose may pass for a current one.
TEST_F(TrackerUpdate, StoppedClockIsLostThenAbsentAndRecovers) {
  Run(50);
  const std::int64_t stands_ns = t_ns;
  for (int i = 1; i <= 100; ++i) {
    pose.position_base_m.x() += 0.4e-3;
    base::HallScan scan = NextScan();
    scan.t_ns = stands_ns;
    Feed(scan);
    ASSERT_EQ(tool.status, i < 18                                 ? TrackingStatus::kTracking
                           : i < 18 + config.lost_after_scans - 1 ? TrackingStatus::kLost
                                                                  : TrackingStatus::kAbsent)
        << i;
    EXPECT_TRUE(tool.status != TrackingStatus::kTracking || Error_m() < 0.01) << i;
    EXPECT_EQ(tool.limits & base::kToolRepeated, base::kToolRepeated) << i;
  }
  Run(3);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_EQ(tool.limits, 0u);
  EXPECT_LT(Error_m(), 1e-3);
}

TEST_F(TrackerUpdate, StillPenIsFilteredBelowSingleScanNoise) {
  config.drift.enabled = false;  // what it allows for slowly wanders
  Run(200);
  double filtered = 0, single = 0;
  for (int i = 0; i < 500; ++i) {
    const base::HallScan scan = NextScan();
    Feed(scan);
    filtered += Error_m() * Error_m();
    const Fit fit = SolvePose(config.model, MakeMeasurement(config.model, config.trust, scan, {}, {}), pose, 0, 8);
    single += (fit.pose.position_base_m - pose.position_base_m).squaredNorm();
  }
  EXPECT_LT(filtered, 0.4 * single);
}

TEST_F(TrackerUpdate, EstimatesVelocityOfAMovingPen) {
  const Vector3d v(0.15, 0.1, 0.05);
  const Vector3d w(2, -1, 0);
  double sum_m = 0;
  for (int i = 0; i < 150; ++i) {
    pose.position_base_m += 1e-3 * v;
    pose.axis_base = base::ToEigen(TurnAxis(base::FromEigen(pose.axis_base), base::FromEigen(1e-3 * w)));
    Run(1);
    if (i >= 50) sum_m += Error_m() / 100;
  }
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_LT(sum_m, 5e-4);
  EXPECT_LT((base::ToEigen(tool.velocity_base_m_s) - v).norm(), 0.05);
  const Vector3d w_visible = w - w.dot(pose.axis_base) * pose.axis_base;
  EXPECT_LT((base::ToEigen(tool.angular_velocity_base_rad_s) - w_visible).norm(), 1.0);
  EXPECT_NEAR(base::ToEigen(tool.angular_velocity_base_rad_s).dot(base::ToEigen(tool.axis_base)), 0, 1e-9);
}

// Sensors sampled up to 1 ms before the stamp, pen at 0.5 m/s: uncorrected this would be 0.25 mm of lag on average.
TEST_F(TrackerUpdate, SensorAgesAreCompensated) {
  noise_scale = 0;
  const Vector3d v(0.3, 0.4, 0);
  pose.position_base_m = {-0.03, -0.04, 0.06};
  double sum_m = 0;
  for (int i = 0; i < 200; ++i) {
    pose.position_base_m += 1e-3 * v;
    const Pose now = pose;
    base::HallScan scan = NextScan();
    for (std::size_t s = 0; s < kSensors; ++s) {
      scan.age_ns[s] = static_cast<std::int64_t>(s) * 130'000;
      pose.position_base_m = now.position_base_m - 1e-9 * static_cast<double>(scan.age_ns[s]) * v;
      scan.field_sensor_T[s] = support::MakeScan(config.model, pose, t_ns, rng).field_sensor_T[s];
    }
    pose = now;
    Feed(scan);
    if (i >= 100) sum_m += Error_m() / 100;
  }
  EXPECT_LT(sum_m, 2e-5);
}

TEST_F(TrackerUpdate, CoilCurrentsDoNotMoveThePose) {
  noise_scale = 0;
  coil_current_A = {4, -3, 2};
  Run(8);  // without noise, more are frozen
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_LT(Error_m(), 1e-5);
}

// A ramp of 400 A/s: without interpolation, up to 0.4 A of error and a wrong pose.
TEST_F(TrackerUpdate, ChangingCurrentsAreInterpolatedToEachSensorsInstant) {
  noise_scale = 0;
  const auto ramp_A = [](double t_s) { return std::array<double, 3>{400 * t_s, -300 * t_s, 200 * t_s}; };
  for (int i = 0; i < 25; ++i) {
    base::HallScan scan = NextScan();
    scan.coil_current_A = ramp_A(1e-3 * i - config.trust.current_age_s);
    for (std::size_t s = 0; s < kSensors; ++s) {
      scan.age_ns[s] = static_cast<std::int64_t>(s) * 100'000;
      const auto then_A = ramp_A(1e-3 * i - 1e-4 * static_cast<double>(s));
      scan.field_sensor_T[s] = support::MakeScan(config.model, pose, t_ns, rng, {0, then_A}).field_sensor_T[s];
    }
    Feed(scan);
    if (i > 10) {  // the first scan cannot know the rate
      EXPECT_LT(Error_m(), 2e-5);
    }
  }
}

// A current that changes its slope in every control step, 5 A from one to the next: it is interpolated to where each
// sensor sampled, up to two ticks back; its mean would be wrong by amperes.
TEST_F(TrackerUpdate, ControlStepCurrentsAreInterpolatedToEachSensor) {
  noise_scale = 0;
  Run(20);  // currents that change like this are no beginning
  const auto knot_A = [](std::int64_t j) {
    return std::array<double, 3>{j % 2 != 0 ? 5.0 : 0.0, static_cast<double>(j % 3) - 1, 2.0};
  };
  const auto at_A = [&](std::int64_t then_ns) {
    const std::int64_t j = then_ns / 250'000;
    const double share = static_cast<double>(then_ns % 250'000) / 250e3;
    std::array<double, 3> now_A = knot_A(j);
    for (std::size_t k = 0; k < 3; ++k) now_A[k] += share * (knot_A(j + 1)[k] - knot_A(j)[k]);
    return now_A;
  };
  for (int i = 0; i < 60; ++i) {
    base::HallScan scan = NextScan();
    scan.sequence = static_cast<std::uint64_t>(i);
    scan.has_steps = 1;
    scan.tick_lead_ns = 1000 * ((37 * i) % 400);
    const std::int64_t end_ns = scan.t_ns;  // ticks are even, stamps are not
    scan.t_ns -= scan.tick_lead_ns;
    for (std::size_t s = 0; s < base::kStepsPerTick; ++s) {
      scan.step_current_A[s] = at_A(end_ns - 250'000 * static_cast<std::int64_t>(base::kStepsPerTick - 1 - s));
    }
    for (std::size_t s = 0; s < kSensors; ++s) {
      scan.age_ns[s] = static_cast<std::int64_t>(s) * 130'000;
      const auto then_A = at_A(scan.t_ns - scan.age_ns[s]);
      scan.field_sensor_T[s] = support::MakeScan(config.model, pose, t_ns, rng, {0, then_A}).field_sensor_T[s];
    }
    Feed(scan);
    if (i > 10) {
      EXPECT_LT(Error_m(), 2e-5) << i;
    }
  }
}

// Stamps lag the device's tick by the age of the newest sensor.
TEST(TrackerCurrents, TickEndIsEstimatedFromTheTimestamps) {
  CurrentHistory history;
  base::HallScan scan;
  double worst_s = 0;
  for (int tick = 0; tick < 3000; ++tick) {
    const std::int64_t lead_ns = std::abs(tick % 250 - 125) * 1000;  // touches zero every 250 ticks
    scan.sequence = static_cast<std::uint64_t>(tick);
    scan.t_ns = 5'000'000'000 + tick * 1'000'000LL - lead_ns;
    history = UpdatedHistory(scan, history);
    if (tick > 300) worst_s = std::max(worst_s, std::abs(history.stamp_lead_s - 1e-9 * static_cast<double>(lead_ns)));
  }
  EXPECT_LT(worst_s, 3e-5);
}

TEST_F(TrackerUpdate, LostPenHoldsPoseThenTurnsAbsentAndIsFoundAgain) {
  const Vector3d v(0.1, 0, 0);
  for (int i = 0; i < 50; ++i) {
    pose.position_base_m += 1e-3 * v;
    Run(1);
  }
  const base::ToolState last = tool;
  base::HallScan nothing;
  for (int i = 1; i < config.lost_after_scans; ++i) {
    nothing.t_ns = t_ns += 1'000'000;
    Feed(nothing);
    ASSERT_EQ(tool.status, TrackingStatus::kLost);
    EXPECT_EQ(tool.position_base_m, last.position_base_m);
    EXPECT_EQ(tool.axis_base, last.axis_base);
  }
  EXPECT_LT(base::ToEigen(tool.velocity_base_m_s).norm(), 0.2 * base::ToEigen(last.velocity_base_m_s).norm());
  nothing.t_ns = t_ns += 1'000'000;
  Feed(nothing);
  EXPECT_EQ(tool.status, TrackingStatus::kAbsent);
  EXPECT_EQ(tool.velocity_base_m_s, base::Vec3{});
  EXPECT_EQ(tool.position_base_m, last.position_base_m);
  pose = {{-0.04, 0.03, 0.05}, Vector3d(0.3, 0, 1).normalized()};
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_LT(Error_m(), 2e-3);
}

TEST_F(TrackerUpdate, PersistentJumpIsAcceptedWithoutFalseVelocity) {
  Run(50);
  const base::ToolState before = tool;
  pose = {{-0.04, 0.03, 0.05}, Vector3d(0.3, 0, 1).normalized()};
  for (int i = 0; i < config.jump_scans; ++i) {
    Run(1);
    EXPECT_EQ(tool.status, TrackingStatus::kLost);
    EXPECT_EQ(tool.position_base_m, before.position_base_m);
  }
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_LT(Error_m(), 2e-3);
  EXPECT_LT(base::ToEigen(tool.velocity_base_m_s).norm(), 0.5);
}

TEST_F(TrackerUpdate, SingleScanJumpIsRejected) {
  Run(50);
  const Pose here = pose;
  pose = {{-0.04, 0.03, 0.05}, Vector3d(0.3, 0, 1).normalized()};
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kLost);
  pose = here;
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
  EXPECT_LT(Error_m(), 1e-3);
}

TEST_F(TrackerUpdate, NeverSeenPenIsAbsent) {
  noise_scale = 0;
  base::HallScan nothing;
  for (int i = 0; i < 50; ++i) {
    nothing.t_ns = t_ns += 1'000'000;
    Feed(nothing);
    ASSERT_EQ(tool.status, TrackingStatus::kAbsent);
    ASSERT_FALSE(tool.ever_tracked);
  }
}

TEST_F(TrackerUpdate, PenOutOfReachIsAbsent) {
  pose = {{0, 0.1, 0.4}, Vector3d(0, 0, -1)};
  for (int i = 0; i < 30; ++i) {
    Run(1);
    ASSERT_EQ(tool.status, TrackingStatus::kAbsent);
  }
}

TEST_F(TrackerUpdate, SaturatedAxesOnlyReduceDegreesOfFreedom) {
  Run(50);
  for (int i = 0; i < 50; ++i) {
    base::HallScan scan = NextScan();
    scan.field_sensor_T[0] = {1.6e-3, -1.6e-3, 1.6e-3};
    scan.saturated_mask = 7;
    Feed(scan);
    ASSERT_EQ(tool.status, TrackingStatus::kTracking);
    EXPECT_EQ(tool.dof, 16);
  }
  EXPECT_LT(Error_m(), 1.5e-3);
}

TEST_F(TrackerUpdate, ScanWithOneWrongSensorIsRejected) {
  Run(50);
  base::HallScan scan = NextScan();
  scan.field_sensor_T[2].x += 1e-4;
  Feed(scan);
  EXPECT_EQ(tool.status, TrackingStatus::kLost);
  EXPECT_LT(Error_m(), 1e-3);
  Run(1);
  EXPECT_EQ(tool.status, TrackingStatus::kTracking);
}

TEST_F(TrackerUpdate, ClockJumpsKeepThePose) {
  Run(50);
  for (const std::int64_t jump : {std::int64_t{0}, std::int64_t{-5'000'000}, std::int64_t{3'000'000'000}}) {
    base::HallScan scan = NextScan();
    t_ns = scan.t_ns = state.pose.filter_t_ns + jump;
    Feed(scan);
    EXPECT_EQ(tool.status, TrackingStatus::kTracking);
    EXPECT_LT(Error_m(), 1e-3);
  }
}

// Each way to corrupt a scan: the state stays finite, and a good scan afterwards tracks.
TEST_F(TrackerUpdate, RecoversFromMalformedScansWithFiniteOutput) {
  using Breaker = std::function<void(base::HallScan&)>;
  const std::vector<Breaker> breakers{
      [](base::HallScan& s) {
        s.field_sensor_T.fill({kNaN, kNaN, kNaN});
      },
      [](base::HallScan& s) {
        s.field_sensor_T.fill({kInf, -kInf, kInf});
      },
      [](base::HallScan& s) {
        s.field_sensor_T.fill({1e300, 1e300, -1e300});
      },
      [](base::HallScan& s) {
        s.field_sensor_T.fill({1e-300, 1e-310, 0});
      },
      [](base::HallScan& s) {
        s.field_sensor_T.fill({1e-3, 1e-3, 1e-3});
      },
      [](base::HallScan& s) { s.field_sensor_T.fill({}); },
      [](base::HallScan& s) { s.saturated_mask = ~0u; },
      [](base::HallScan& s) {
        s.coil_current_A = {kNaN, 0, 0};
      },
      [](base::HallScan& s) {
        s.coil_current_A = {1e300, -kInf, 0};
      },
      [](base::HallScan& s) {
        s.coil_current_A = {900, -900, 900};
      },
      [](base::HallScan& s) { s.age_ns.fill(-1); },
      [](base::HallScan& s) { s.age_ns.fill(std::numeric_limits<std::int64_t>::max()); },
      [](base::HallScan& s) { s.t_ns = std::numeric_limits<std::int64_t>::min(); },
      [](base::HallScan& s) { s.t_ns = std::numeric_limits<std::int64_t>::max(); },
      [](base::HallScan& s) { std::reverse(s.field_sensor_T.begin(), s.field_sensor_T.end()); },
      [](base::HallScan& s) {
        for (auto& B : s.field_sensor_T) B = {-B.x, -B.y, -B.z};
      },
      [](base::HallScan& s) {
        for (std::size_t i = 0; i < 8; i += 2) s.field_sensor_T[i].z = kNaN;
      },
      [](base::HallScan& s) {
        for (std::size_t i = 0; i < 7; ++i) s.field_sensor_T[i].z = kNaN;
      },
  };
  for (std::size_t b = 0; b < breakers.size(); ++b) {
    SCOPED_TRACE(b);
    for (const int scans : {1, 30}) {
      state = {};
      t_ns = 1'000'000'000;
      Run(20);
      for (int i = 0; i < scans; ++i) {
        base::HallScan scan = NextScan();
        breakers[b](scan);
        Feed(scan);
      }
      Run(10);
      EXPECT_EQ(tool.status, TrackingStatus::kTracking);
      EXPECT_LT(Error_m(), 1e-3);
    }
    state = {};
    base::HallScan scan = NextScan();
    breakers[b](scan);
    Feed(scan);
  }
}

TEST_F(TrackerUpdate, OutputStaysFiniteForRandomlyCorruptedScans) {
  for (int i = 0; i < 5'000; ++i) {
    base::HallScan scan = NextScan();
    auto* bytes = reinterpret_cast<unsigned char*>(&scan);
    const int flips = 1 + static_cast<int>(rng() % 40);
    for (int f = 0; f < flips; ++f) bytes[rng() % sizeof scan] = static_cast<unsigned char>(rng());
    Feed(scan);
  }
}

TEST_F(TrackerUpdate, EqualScansGiveBitIdenticalResults) {
  State second;
  for (int i = 0; i < 100; ++i) {
    const base::HallScan scan = NextScan();
    Feed(scan);
    base::ToolState other;
    Update(config, scan, second, other);
    ASSERT_TRUE(support::SameBits(tool, other));
  }
}

TEST(TrackerPredict, ExtrapolatesPoseForAtMostTwentyMilliseconds) {
  base::ToolState tool;
  tool.t_ns = 5'000'000;
  tool.position_base_m = {0, 0, 0.05};
  tool.axis_base = {0, 0, -1};
  tool.velocity_base_m_s = {0.1, 0, 0};
  tool.angular_velocity_base_rad_s = {0, 2, 0};
  const base::ToolState ahead = Predict(tool, tool.t_ns + 10'000'000, 0.005);
  EXPECT_EQ(ahead.t_ns, tool.t_ns + 10'000'000);
  EXPECT_NEAR(ahead.position_base_m.x, 1e-3, 1e-15);
  EXPECT_NEAR(ahead.axis_base.x, -std::sin(0.02), 1e-12);
  EXPECT_NEAR(ahead.device_point_base_m.x, 1e-3 - 0.005 * std::sin(0.02), 1e-12);
  EXPECT_NEAR(ahead.device_point_velocity_base_m_s.x, 0.1 - 0.005 * 2 * std::cos(0.02), 1e-9);
  EXPECT_EQ(Predict(tool, tool.t_ns + 1'000'000'000, 0.005).t_ns, tool.t_ns + 20'000'000);
  EXPECT_EQ(Predict(tool, std::numeric_limits<std::int64_t>::min(), 0.005).t_ns, tool.t_ns - 20'000'000);
}

// A pen carried past is no sign of a wrong calibration.
TEST_F(TrackerUpdate, PenOutOfReachDoesNotReportContradiction) {
  for (const Pose& away : {Pose{{0, 0, 0.30}, Vector3d(0, 0, -1)}, Pose{{0.28, 0, 0.02}, Vector3d(-1, 0, 0)},
                           Pose{{0.13, 0, -0.10}, Vector3d(-1, 0, 0)}, Pose{{0, 0, 0.5}, Vector3d(0, 0, -1)}}) {
    state = {};
    pose = away;
    int contradicted = 0;
    for (int i = 0; i < 200; ++i) {
      Feed(NextScan());
      ASSERT_NE(tool.status, TrackingStatus::kTracking);
      contradicted += (tool.limits & base::kToolContradicted) != 0 ? 1 : 0;
    }
    EXPECT_LE(contradicted, 10) << away.position_base_m.transpose();
  }
}

TEST_F(TrackerUpdate, ReportsFieldStrengthAndContradictionWhenNoPoseFits) {
  Run(20);
  EXPECT_GT(tool.field_rms_T, 1.5e-4) << "a pen near the hull";
  base::DeviceGeometry other = support::NominalDevice();
  int side = 1;
  for (base::SensorGeometry& sensor : other.sensors) {  // the sensors of another base: 3 mm off
    sensor.position_base_m.z += 3e-3 * side;
    side = -side;
  }
  Config wrong = MakeConfig(magnetics::NominalCalibration(other));
  state = {};
  for (int i = 0; i < 200; ++i) {
    Update(wrong, NextScan(), state, tool);
    ASSERT_EQ(tool.status, TrackingStatus::kAbsent);
    EXPECT_EQ(tool.limits & base::kToolContradicted, base::kToolContradicted) << "also while no start is tried";
  }
  EXPECT_GT(tool.field_rms_T, 1.5e-4);
}

}  // namespace test_tracker_update
}  // namespace omni::tracker
