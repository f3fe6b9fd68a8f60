// From scans to what calibration works on: windows of a moving pen, touches, the coil sweep.
#include <gtest/gtest.h>

#include <cmath>

#include "service/calibration/checks/coil_sweep.h"
#include "service/calibration/fit/window.h"
#include "service/calibration/types.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::calibration {
namespace test_calibration_recording {

constexpr std::array<double, 3> kNoise_T{8e-7, 8e-7, 1e-6};

// Sensor i's field at time t: a slow wave with a phase of its own.
double Wave(std::size_t i, double t_s) { return 1e-4 * std::sin(6 * t_s + static_cast<double>(i)); }

base::HallScan WaveScan(int tick, sim::Random& random) {
  base::HallScan scan;
  scan.sequence = static_cast<std::uint64_t>(tick);
  scan.t_ns = 1'000'000'000LL + 1'000'000LL * tick;
  scan.fresh_mask = 0xff;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    scan.age_ns[i] = 100'000LL * static_cast<std::int64_t>(i);
    const double t_s = 1e-9 * static_cast<double>(scan.t_ns - scan.age_ns[i]);
    scan.field_sensor_T[i] = {Wave(i, t_s) + kNoise_T[0] * random.Normal(), kNoise_T[1] * random.Normal(),
                              kNoise_T[2] * random.Normal()};
  }
  return scan;
}

TEST(CalibrationRecording, WindowInterpolatesAllSensorsToOneInstant) {
  Window window({}, kNoise_T);
  sim::Random random(3);
  double square = 0;
  int count = 0;
  for (int tick = 0; tick < 24 * 200; ++tick) {
    const auto result = window.Add(WaveScan(tick, random));
    if (!result) continue;
    const Sample& sample = result->sample;
    ASSERT_EQ(sample.field_sensor_T.size(), 8u);
    EXPECT_GT(sample.noise_scale, 0.2);
    EXPECT_LT(sample.noise_scale, 0.4);
    for (std::size_t i = 0; i < 8; ++i) {
      const double off = (sample.field_sensor_T[i].x - Wave(i, sample.t_s)) / (sample.noise_scale * kNoise_T[0]);
      square += off * off;
      ++count;
    }
  }
  EXPECT_GT(count, 8 * 190);
  EXPECT_NEAR(square / count, 1, 0.15);
}

TEST(CalibrationRecording, JerkyWindowsAreDroppedAndInvalidAxesBecomeNaN) {
  Window window({}, kNoise_T);
  sim::Random random(4);
  for (int tick = 0; tick < 24; ++tick) {
    base::HallScan scan = WaveScan(tick, random);
    if (tick > 14) scan.field_sensor_T[3].y += 2e-5;
    EXPECT_FALSE(window.Add(scan).has_value());
  }
  for (int tick = 24; tick < 48; ++tick) {
    base::HallScan scan = WaveScan(tick, random);
    if (tick == 30) scan.saturated_mask = 1U << (3 * 5 + 2);
    scan.field_sensor_T[6].x = std::nan("");
    const auto result = window.Add(scan);
    if (tick < 47) continue;
    ASSERT_TRUE(result.has_value());
    EXPECT_TRUE(std::isnan(result->sample.field_sensor_T[5].z));
    EXPECT_TRUE(std::isfinite(result->sample.field_sensor_T[5].x));
    EXPECT_TRUE(std::isnan(result->sample.field_sensor_T[6].x));
  }
}

TEST(CalibrationRecording, RestAtANewPlaceCountsAsOneTouch) {
  TouchPicker picker;
  const auto rest = [](double place, bool still) {
    WindowResult window;
    window.still = still;
    window.sample.field_sensor_T.assign(8, {1e-4 + place * 1e-5, 2e-4, place * 1e-5});
    return window;
  };
  int touches = 0;
  const auto feed = [&](double place, bool still, int windows) {
    for (int i = 0; i < windows; ++i) {
      const auto touch = picker.Add(rest(place, still));
      if (touch) {
        EXPECT_TRUE(touch->touches_hull);
      }
      touches += touch ? 1 : 0;
    }
  };
  feed(0, true, 2);
  EXPECT_EQ(touches, 0);  // too short
  feed(0, true, 20);
  EXPECT_EQ(touches, 1);  // once
  feed(3, false, 20);
  EXPECT_EQ(touches, 1);  // moving
  feed(3, true, 10);
  EXPECT_EQ(touches, 2);
  picker.AddJerk();
  feed(3.01, true, 10);
  EXPECT_EQ(touches, 2);  // the same place
}

TEST(CalibrationRecording, SweepYieldsCurrentMapsAndBackground) {
  sim::RigOptions options{.seed = 5, .noise = sim::NoiseMode::kLowPower};
  options.sizes.current_offset_A = 0;
  options.sizes.current_gain = 0;
  sim::Rig rig(support::NominalDevice(), options);
  sim::Random random(6);
  CoilSweep sweep;
  const base::Vec3 background{3e-5, -2e-5, 1e-5};
  for (const SweepStep& step : MakeSweep({})) {
    for (int i = 0; i < step.scans; ++i) {
      base::HallScan scan = rig.Scan(nullptr, step.current_A, random);
      for (base::Vec3& B : scan.field_sensor_T) B = {B.x + background.x, B.y + background.y, B.z + background.z};
      sweep.Add(scan, step.rest);
    }
  }
  const auto responses = sweep.Finish();
  ASSERT_TRUE(responses.ok()) << responses.error();
  const base::Calibration exact = rig.ExactCalibration();
  for (std::size_t i = 0; i < 8; ++i) {
    const CoilResponse& response = (*responses)[i];
    for (std::size_t e = 0; e < 9; ++e) {
      EXPECT_NEAR(response.map_sensor_T_A[e], exact.sensors[i].current_map_T_A[e], 1e-7) << i << " " << e;
    }
    EXPECT_NEAR(response.background_sensor_T.x, background.x, 1.5e-7);
    EXPECT_NEAR(response.background_sensor_T.z, background.z, 1.5e-7);
    EXPECT_LT(response.map_error_T_A, 2e-7);
    EXPECT_GT(response.map_error_T_A, 1e-9);
  }
}

TEST(CalibrationRecording, SweepRejectsMissingCurrentsAndReadings) {
  sim::Rig rig(support::NominalDevice(), {.seed = 5});
  sim::Random random(6);
  EXPECT_NE(CoilSweep().Finish().error().find("0 steady scans"), std::string::npos);
  CoilSweep one_coil;
  for (SweepStep step : MakeSweep({})) {
    step.current_A[1] = 0;
    for (int i = 0; i < step.scans; ++i) one_coil.Add(rig.Scan(nullptr, step.current_A, random), step.rest);
  }
  EXPECT_NE(one_coil.Finish().error().find("coil y carried"), std::string::npos);
  CoilSweep broken;
  for (const SweepStep& step : MakeSweep({})) {
    for (int i = 0; i < step.scans; ++i) {
      base::HallScan scan = rig.Scan(nullptr, step.current_A, random);
      scan.field_sensor_T[2].x = std::nan("");
      broken.Add(scan, step.rest);
    }
  }
  EXPECT_NE(broken.Finish().error().find("sensor 2 gives nothing (not a number"), std::string::npos);
}

TEST(CalibrationRecording, SweepNamesAStuckOrSilentSensor) {
  sim::Rig rig(support::NominalDevice(), {.seed = 5});
  sim::Random random(6);
  CoilSweep stuck, silent;
  const base::Vec3 held = rig.Scan(nullptr, {}, random).field_sensor_T[6];
  for (const SweepStep& step : MakeSweep({})) {
    for (int i = 0; i < step.scans; ++i) {
      base::HallScan scan = rig.Scan(nullptr, step.current_A, random);
      scan.field_sensor_T[6] = held;
      stuck.Add(scan, step.rest);
      scan.age_ns[6] = 20'000'000;
      silent.Add(scan, step.rest);
    }
  }
  EXPECT_NE(stuck.Finish().error().find("sensor 6 repeats itself; check its cable"), std::string::npos);
  EXPECT_NE(silent.Finish().error().find("sensor 6 gives nothing"), std::string::npos);
}

TEST(CalibrationRecording, CoverageCountsCellsOfEqualArea) {
  Coverage coverage;
  EXPECT_EQ(coverage.share(), 0);
  coverage.Add({0, 0, -0.1});  // below
  coverage.Add({0, 0, 0});     // nowhere
  EXPECT_EQ(coverage.share(), 0);
  coverage.Add({0, 0, 0.1});
  EXPECT_NEAR(coverage.share(), 1.0 / kCoverageCells, 1e-12);
  const sim::Rig rig(support::NominalDevice(), {});
  sim::Random random(7);
  for (int i = 0; i < 24000; ++i) {
    const double z = random.Uniform();
    const double angle = 6.283185307179586 * random.Uniform();
    const double rho = std::sqrt(1 - z * z);
    coverage.Add({rho * std::cos(angle), rho * std::sin(angle), z});
  }
  EXPECT_EQ(coverage.share(), 1);
  for (const int visits : coverage.visits) EXPECT_NEAR(visits, 1000, 150);
}

}  // namespace test_calibration_recording
}  // namespace omni::calibration
