// Moving traces: the path's limits, and scans that match it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/trace.h"
#include "tests/support/same_bits.h"

namespace omni::sim {
namespace test_sim_trace {

double TiltOf(const MagnetPose& pose) {
  return std::acos(std::clamp(-Dot(pose.axis_base, Normalized(pose.centre_base_m)), -1.0, 1.0));
}

TEST(SimMotion, StaysWithinItsRadiusAndSpeedAndClearOfTheHull) {
  const base::DeviceGeometry device = support::NominalDevice();
  for (const std::uint64_t seed : {3U, 14U, 159U}) {
    const MotionOptions options{.seed = seed};
    const FreeMotion motion(device, options, 20);
    double fastest_m_s = 0;
    double nearest_m = 1;
    double farthest_m = 0;
    double steepest_rad = 0;
    for (int i = 0; i <= 40000; ++i) {
      const FreeMotion::State state = motion.StateAt(i * 0.5e-3);
      const MagnetPose& pose = state.pose;
      ASSERT_NEAR(Norm(pose.axis_base), 1, 1e-12);
      ASSERT_LE(Norm(pose.centre_base_m), options.radius_max_m + 1e-12);
      ASSERT_GE(pose.centre_base_m.z, -1e-12);
      nearest_m = std::min(nearest_m, GapToHull(device.magnet, device.hull_radius_m, pose).gap_m);
      farthest_m = std::max(farthest_m, Norm(pose.centre_base_m));
      steepest_rad = std::max(steepest_rad, TiltOf(pose));
      fastest_m_s = std::max(fastest_m_s, Norm(state.velocity_base_m_s));
    }
    EXPECT_GE(nearest_m, 0);
    EXPECT_LT(nearest_m, 0.01) << "it comes near";
    EXPECT_GT(farthest_m, 0.085) << "and goes far";
    EXPECT_LE(steepest_rad, options.tilt_max_rad + 1e-9);
    EXPECT_GT(steepest_rad, 0.8);
    EXPECT_LE(fastest_m_s, options.speed_max_m_s);
    EXPECT_GT(fastest_m_s, 0.6 * options.speed_max_m_s);
  }
}

TEST(SimMotion, VelocityIsTheDerivativeOfThePosition) {
  const FreeMotion motion(support::NominalDevice(), {.seed = 6, .tremor_m = 1e-4}, 5);
  for (int i = 1; i < 400; ++i) {
    const double t_s = i * 0.0121;
    const double h = 1e-5;
    const Vec3 slope =
        (0.5 / h) * (motion.StateAt(t_s + h).pose.centre_base_m - motion.StateAt(t_s - h).pose.centre_base_m);
    EXPECT_LT(Norm(slope - motion.StateAt(t_s).velocity_base_m_s), 2e-3) << t_s;
  }
}

TraceOptions Short() {
  TraceOptions options;
  options.duration_s = 0.4;
  options.seed = 8;
  options.motion.seed = 9;
  return options;
}

bool Same(const std::vector<TraceRow>& a, const std::vector<TraceRow>& b) {
  return a.size() == b.size() && support::SameBits(a.back().scan, b.back().scan);
}

TEST(SimTrace, EqualOptionsGiveBitIdenticalTraces) {
  RigOptions rig_options{.seed = 4, .noise = NoiseMode::kLowPower};
  rig_options.effects.remanence_Am2 = 4e-3;
  rig_options.effects.core_conductivity_S_m = 1e7;
  rig_options.effects.pwm_frequency_Hz = 20e3;
  Rig rig(support::NominalDevice(), rig_options);
  TraceOptions options = Short();
  options.currents = StaggeredSawtooth(4, 0.3);
  const auto first = RecordTrace(rig, options);
  ASSERT_EQ(first.size(), 400U);
  EXPECT_TRUE(Same(first, RecordTrace(rig, options)));
  options.seed = 10;
  EXPECT_FALSE(Same(first, RecordTrace(rig, options)));
}

// Without noise and effects a scan is the static reading at each sensor's own instant.
TEST(SimTrace, ScansSampleThePathAtEachSensorsInstant) {
  Rig rig(support::NominalDevice(), {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  const TraceOptions options = Short();
  const auto rows = RecordTrace(rig, options);
  const FreeMotion motion(support::NominalDevice(), options.motion, options.duration_s + 1e-3);
  const std::int64_t start_ns = 1'000'000'000;
  for (std::size_t i = 20; i < rows.size(); i += 20) {
    const base::HallScan& scan = rows[i].scan;
    ASSERT_NEAR(static_cast<double>(rows[i].tick_end_ns - start_ns), 1e6 * static_cast<double>(i + 1), 1);
    EXPECT_EQ(rows[i].pose.centre_base_m,
              motion.StateAt(static_cast<double>(scan.t_ns - start_ns) * 1e-9).pose.centre_base_m);
    for (std::size_t s = 0; s < base::kSensorCount; ++s) {
      const MagnetPose pose = motion.StateAt(static_cast<double>(scan.t_ns - scan.age_ns[s] - start_ns) * 1e-9).pose;
      const Vec3 expected_T = rig.Readings(&pose, {})[s];
      EXPECT_LT(Norm(scan.field_sensor_T[s] - expected_T), 2e-3 * Norm(expected_T) + 1e-7) << i << " " << s;
    }
  }
}

// The saw-tooth rises for its period and falls within the coil's lag; measured and true currents differ by the sensor.
TEST(SimTrace, SawtoothCurrentsStayWithinTheirAmplitude) {
  RigOptions rig_options{.sizes = NoImperfections()};
  Rig rig(support::NominalDevice(), rig_options);
  TraceOptions options = Short();
  options.duration_s = 2;
  options.currents = StaggeredSawtooth(4, 1);
  double sum_A = 0;
  double greatest_A = 0;
  const auto rows = RecordTrace(rig, options);
  for (const TraceRow& row : rows) {
    for (std::size_t k = 0; k < 3; ++k) {
      greatest_A = std::max(greatest_A, std::abs(row.current_A[k]));
      sum_A += row.current_A[k];
    }
  }
  EXPECT_LT(greatest_A, 4.001);
  EXPECT_GT(greatest_A, 3.95);
  EXPECT_LT(std::abs(sum_A) / static_cast<double>(rows.size()), 0.2);
  EXPECT_EQ(rows.back().scan.device_faults, 0U);
}

TEST(SimTrace, NoFieldWithoutAPen) {
  Rig rig(support::NominalDevice(), {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  TraceOptions options = Short();
  options.present = false;
  for (const TraceRow& row : RecordTrace(rig, options)) EXPECT_EQ(row.scan.field_sensor_T[0], Vec3{});
}

// Eddy currents: a core that cannot follow reads less while the current rises.
TEST(SimTrace, EffectsChangeTheScans) {
  RigOptions plain{.sizes = NoImperfections(), .noise = NoiseMode::kNone};
  RigOptions effects = plain;
  effects.effects.core_conductivity_S_m = 1e7;
  effects.effects.remanence_Am2 = 4e-3;
  effects.effects.ambient_drift_T = 5e-7;
  effects.effects.run_s = 0.4;
  Rig without(support::NominalDevice(), plain);
  Rig with(support::NominalDevice(), effects);
  const auto a = RecordTrace(without, Short());
  const auto b = RecordTrace(with, Short());
  double greatest_T = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    greatest_T = std::max(greatest_T, Norm(a[i].scan.field_sensor_T[2] - b[i].scan.field_sensor_T[2]));
  }
  EXPECT_GT(greatest_T, 2e-7);
  EXPECT_LT(greatest_T, 2e-5);
}

}  // namespace test_sim_trace
}  // namespace omni::sim
