// The field of mains: found, subtracted, tuned and forgotten; nothing is found where there is none.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "service/magnetics/nominal.h"
#include "service/tracker/tracker.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_mains {

using base::TrackingStatus;
using Eigen::Vector3d;

constexpr int kJudged = 2000;  // scans

class TrackerMains : public testing::Test {
 protected:
  Config config = MakeConfig(magnetics::NominalCalibration(support::NominalDevice()));
  State state;
  base::ToolState tool;
  support::Rng rng{23};
  std::int64_t t_ns = 1'000'000'000;
  Pose pose;
  double amplitude_T = 0, frequency_Hz = 50, third = 0;
  double higher_m = 0;
  Vector3d steady_T = Vector3d::Zero();
  Vector3d direction = Vector3d(0.7, -0.4, 0.6).normalized();

  Vector3d MainsAt(std::int64_t at_ns) const {
    const double phase_rad = 2 * std::numbers::pi * frequency_Hz * 1e-9 * static_cast<double>(at_ns);
    return amplitude_T * (std::sin(phase_rad + 0.8) + third * std::sin(3 * phase_rad + 2)) * direction;
  }

  // Slow circles over the base, tilting; each sensor is read at its own instant.
  base::HallScan NextScan() {
    t_ns += 1'000'000;
    const double t_s = 1e-9 * static_cast<double>(t_ns);
    pose.position_base_m = {0.03 * std::cos(4 * t_s), 0.03 * std::sin(4 * t_s),
                            0.075 + higher_m + 0.01 * std::sin(3 * t_s)};
    pose.axis_base = Vector3d(0.4 * std::sin(2 * t_s), 0.4 * std::cos(2.5 * t_s), -1).normalized();
    base::HallScan scan = support::MakeScan(config.model, pose, t_ns, rng, {.noise_scale = 1});
    scan.sequence = static_cast<std::uint64_t>(t_ns / 1'000'000);
    for (std::size_t i = 0; i < kSensors; ++i) {
      support::AddField(config.model, i, steady_T + MainsAt(t_ns - scan.age_ns[i]), scan);
    }
    return scan;
  }

  // Mean error over the last two seconds: over one it varies by a fifth.
  double Run_m(double seconds) {
    double sum_m = 0;
    const int scans = static_cast<int>(1000 * seconds);
    for (int n = 0; n < scans; ++n) {
      const base::HallScan scan = NextScan();
      const loop::AllocProbe probe;
      Update(config, scan, state, tool);
      EXPECT_EQ(probe.count(), 0u);
      if (n >= 100) {
        EXPECT_EQ(tool.status, TrackingStatus::kTracking);
      }
      if (n >= scans - kJudged) sum_m += (base::ToEigen(tool.position_base_m) - pose.position_base_m).norm();
    }
    return sum_m / kJudged;
  }
  double FreshRun_m(double seconds) {
    state = {};
    return Run_m(seconds);
  }
};

TEST_F(TrackerMains, MainsFieldIsSubtracted) {
  const double undisturbed_m = FreshRun_m(4);
  EXPECT_FALSE(state.room.mains.found);
  amplitude_T = 2e-6;
  for (const double mains_Hz : {50.0, 60.0, 49.85, 60.2}) {
    SCOPED_TRACE(mains_Hz);
    frequency_Hz = mains_Hz;
    config.mains.enabled = true;
    EXPECT_LT(FreshRun_m(4), 1.3 * undisturbed_m);
    EXPECT_NEAR(state.room.mains.tones[0].frequency_Hz, mains_Hz, 0.06);
    config.mains.enabled = false;
    EXPECT_GT(FreshRun_m(3), 1.9 * undisturbed_m);
  }
}

TEST_F(TrackerMains, MainsFieldAndThirdHarmonicAreEstimated) {
  amplitude_T = 2e-6;
  third = 0.3;
  FreshRun_m(3);
  ASSERT_TRUE(state.room.mains.found);
  EXPECT_TRUE(state.room.mains.tones[1].believed);
  const AmbientChange change = FieldOfMains(state.room.mains);
  const Vector3d found_T(change.field_T[0], change.field_T[1], change.field_T[2]);
  EXPECT_LT((found_T - MainsAt(t_ns)).norm(), 0.3 * amplitude_T);
}

// Where noise exceeds half a second's evidence of a tone, the evidence is kept for longer.
TEST_F(TrackerMains, WeakMainsToneIsRetained) {
  amplitude_T = 5e-7;
  higher_m = 0.012;
  FreshRun_m(4);
  int known = 0;
  for (int second = 0; second < 30; ++second) {
    Run_m(1);
    known += state.room.mains.tones[0].believed ? 1 : 0;
  }
  EXPECT_GE(known, 29);
}

// A tone between the sensors' instants: error of the three terms of AmbientChange for 150 Hz a millisecond back.
TEST_F(TrackerMains, MainsFieldIsExtrapolatedToEachSensorsInstant) {
  Mains mains;
  mains.started = mains.found = true;
  mains.tones[0] = {.frequency_Hz = 150, .phase_rad = 0.4, .believed = true};
  mains.tones[0].mean_T = {1e-6, 0, 2e-6, 0, -1e-6, 1e-6};
  const AmbientChange change = FieldOfMains(mains);
  for (const double age_s : {1e-4, 5e-4, 1e-3}) {
    const double phase_rad = 0.4 - 2 * std::numbers::pi * 150 * age_s, omega_age = 2 * std::numbers::pi * 150 * age_s;
    for (std::size_t c = 0; c < 3; ++c) {
      const double a_T = mains.tones[0].mean_T[c], b_T = mains.tones[0].mean_T[3 + c];
      const double true_T = a_T * std::cos(phase_rad) + b_T * std::sin(phase_rad);
      const double reported_T =
          change.field_T[c] - age_s * change.rate_T_s[c] + age_s * age_s / 2 * change.acceleration_T_s2[c];
      EXPECT_LE(std::abs(reported_T - true_T), std::pow(omega_age, 3) / 6 * std::hypot(a_T, b_T) + 1e-15);
    }
  }
}

TEST_F(TrackerMains, MainsToneIsDroppedWhenItEnds) {
  amplitude_T = 2e-6;
  FreshRun_m(2);
  ASSERT_TRUE(state.room.mains.found);
  amplitude_T = 0;
  Run_m(2);
  EXPECT_FALSE(state.room.mains.found);
}

TEST_F(TrackerMains, PauseOrBackwardClockResetsTheTones) {
  amplitude_T = 2e-6;
  FreshRun_m(2);
  ASSERT_TRUE(state.room.mains.found);
  AdvanceMains(config.mains, state.room.mains.t_ns + 1'000'000'000, state.room.mains);
  EXPECT_FALSE(state.room.mains.found);
  AdvanceMains(config.mains, state.room.mains.t_ns - 1, state.room.mains);  // a clock that goes back
  EXPECT_EQ(FieldOfMains(state.room.mains).field_T, (std::array<double, 3>{}));
}

TEST_F(TrackerMains, NoToneIsFoundWithoutMains) {
  state = {};
  for (int n = 0; n < 20'000; ++n) {
    Update(config, NextScan(), state, tool);
    ASSERT_FALSE(state.room.mains.found);
  }
}

// A field that changes at the start or suddenly, or a base that turns, is no tone.
TEST_F(TrackerMains, FieldStepsAndBaseTurnsAreNotTakenForMains) {
  for (const double size_T : {2e-6, 6e-6, 2e-5, 6e-5}) {
    SCOPED_TRACE(size_T);
    state = {};
    for (int n = 0; n < 6000; ++n) {
      steady_T = ((n / 1000) % 2 == 0 ? size_T : 0) * direction;
      if (n > 4000) steady_T = 5e-5 * Vector3d(std::cos(1.5e-3 * n), std::sin(1.5e-3 * n), 0);
      Update(config, NextScan(), state, tool);
      ASSERT_FALSE(state.room.mains.found) << n;
    }
  }
}

// Evidence that is not finite is not learnt.
TEST_F(TrackerMains, IgnoresNonFiniteEvidence) {
  Mains mains;
  AdvanceMains(config.mains, 0, mains);
  AmbientEvidence evidence{.valid = true, .information = {1e12, 0, 0, 0, 1e12, 0, 0, 0, 1e12}, .gradient = {1e6, 0, 0}};
  for (int n = 1; n < 40; ++n) {
    AdvanceMains(config.mains, n * 4'000'000, mains);
    if (n == 20) evidence.gradient[1] = std::numeric_limits<double>::quiet_NaN();
    if (n == 21) evidence.gradient[1] = 0;
    LearnMains(config.mains, evidence, {}, 5e-4, mains);
    for (const double field_T : FieldOfMains(mains).field_T) ASSERT_TRUE(std::isfinite(field_T));
  }
  for (const Tone& tone : mains.tones) EXPECT_TRUE(std::isfinite(tone.chi2 + tone.gradient_1_T[1]));
}

}  // namespace test_tracker_mains
}  // namespace omni::tracker
