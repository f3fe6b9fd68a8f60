// What self-calibration finds on simulated bases, which gauges it holds, and what it reports as unknown.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/magnetics/nominal.h"
#include "tests/support/rig/calibration_error.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::calibration {
namespace test_calibration_recover {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

base::DeviceGeometry Device() {
  base::DeviceGeometry device = support::NominalDevice();
  device.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  return device;
}

sim::RigOptions Uncalibrated(std::uint64_t seed, sim::NoiseMode noise) {
  sim::RigOptions options{.seed = seed, .noise = noise};
  options.sizes.sensor_position_m = 1e-3;
  options.sizes.sensor_gain = 0.015;
  options.sizes.sensor_rotation_rad = 0.02;
  options.sizes.magnet_moment = 0.01;
  return options;
}

double PositionError_m(const base::Calibration& a, const base::Calibration& b) {
  double square = 0;
  for (std::size_t i = 0; i < a.sensors.size(); ++i) {
    square += (base::ToEigen(a.sensors[i].position_base_m) - base::ToEigen(b.sensors[i].position_base_m)).squaredNorm();
  }
  return std::sqrt(square / static_cast<double>(a.sensors.size()));
}

double MeanGain(const base::Calibration& calibration) {
  double sum = 0;
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    sum += Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data()).trace() / 3;
  }
  return sum / static_cast<double>(calibration.sensors.size());
}

bool Names(const std::vector<Undetermined>& unfixed, const std::string& part) {
  return std::any_of(unfixed.begin(), unfixed.end(),
                     [&](const Undetermined& one) { return one.name.find(part) != std::string::npos; });
}

TEST(CalibrationRecover, RecoversSensorsFromNearlyNoiseFreeReadings) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  for (const std::uint64_t seed : {21u, 22u}) {
    sim::RigOptions options = Uncalibrated(seed, sim::NoiseMode::kNone);
    options.sizes.coil_axis_rad = 0;
    options.sizes.coil_strength = 0;
    options.saturation = false;
    sim::Rig rig(device, options);
    const auto outcome = SelfCalibrate(nominal, device.coils, test::MakeRecording(rig, {.seed = seed}));
    ASSERT_TRUE(outcome.ok()) << outcome.error();
    const base::Calibration exact = rig.ExactCalibration();
    EXPECT_GT(PositionError_m(nominal, exact), 1e-3);
    EXPECT_LT(PositionError_m(outcome->calibration, exact), 0.15e-3);
    // Gains are known up to the scale that goes with the moment.
    EXPECT_NEAR(MeanGain(outcome->calibration), 1, 1e-3);
    const double product = outcome->calibration.moment_Am2 * MeanGain(outcome->calibration);
    EXPECT_NEAR(product / (exact.moment_Am2 * MeanGain(exact)), 1, 2e-3);
    EXPECT_LT(outcome->report.chi2_per_dof, 1.2);
  }
}

// The hull .3 mm larger and the core .5 mm off its centre: found from touches and current maps, without errors of
// poses.
TEST(CalibrationRecover, RecoversHullRadiusAndCoreCentre) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  for (const std::uint64_t seed : {51u, 52u, 53u}) {
    sim::RigOptions options = Uncalibrated(seed, sim::NoiseMode::kUltraHigh);
    options.sizes.hull_radius_m = 3e-4;
    options.sizes.core_offset_m = 3e-4;
    sim::Rig rig(device, options);
    const base::Calibration exact = rig.ExactCalibration();
    const Recording recording = test::MakeRecording(rig, {.waves = 300, .touches = 100, .touch_sigma_m = 5e-5});
    const auto outcome = SelfCalibrate(nominal, device.coils, recording);
    ASSERT_TRUE(outcome.ok()) << outcome.error();
    const base::Calibration& found = outcome->calibration;
    const Vector3d centre = base::ToEigen(found.core_centre_base_m) - base::ToEigen(exact.core_centre_base_m);
    EXPECT_LT(centre.norm(), 0.15e-3);
    EXPECT_NEAR(found.hull_radius_m, exact.hull_radius_m, 0.1e-3);
    const auto error = test::MeasureCalibrationError(rig, found, {.noise = false});
    ASSERT_TRUE(error.ok()) << error.error();
    EXPECT_LT(error->raw_mm, 0.2);
    EXPECT_LT(error->raw_mm, 2e3 * outcome->report.expected_error_m);
    Options drawn;
    drawn.tolerances.hull_radius_m = drawn.tolerances.core_centre_m = 1e-7;
    const auto believed = SelfCalibrate(nominal, device.coils, recording, drawn);
    if (!believed.ok()) continue;
    EXPECT_GT(test::MeasureCalibrationError(rig, believed->calibration, {.noise = false})->raw_mm, 2 * error->raw_mm);
  }
}

TEST(CalibrationRecover, NoisyReadingsGiveTheExpectedResiduals) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  sim::Rig rig(device, Uncalibrated(31, sim::NoiseMode::kUltraHigh));
  const Recording recording = test::MakeRecording(rig, {.waves = 300, .touches = 80, .touch_sigma_m = 1e-4, .seed = 8});
  const auto outcome = SelfCalibrate(nominal, device.coils, recording);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  const Report& report = outcome->report;
  EXPECT_GT(report.chi2_per_dof, 0.75);  // remanence has room in every sample, and there is none
  EXPECT_LT(report.chi2_per_dof, 1.1);
  EXPECT_EQ(report.samples, 380);
  EXPECT_EQ(report.touches, 80);
  EXPECT_LT(report.rejected, 10);
  EXPECT_GT(report.coverage, 0.9);
  EXPECT_NEAR(report.touch_rms_m, 1e-4, 0.5e-4);
  ASSERT_EQ(report.sensors.size(), 8u);
  for (const SensorReport& sensor : report.sensors) {
    EXPECT_GT(sensor.residual_T, 1e-7);
    EXPECT_LT(sensor.residual_T, 6e-7);
    EXPECT_GT(sensor.chi2_per_reading, 0.4);
    EXPECT_LT(sensor.chi2_per_reading, 1.2);
  }
  EXPECT_LT(PositionError_m(outcome->calibration, rig.ExactCalibration()), 0.4e-3);
}

// A recording whose gains are all larger and whose magnet is weaker by the same factor is the same recording.
TEST(CalibrationRecover, CommonGainScaleIsAbsorbedByTheMoment) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  sim::Rig rig(device, Uncalibrated(41, sim::NoiseMode::kUltraHigh));
  Recording recording = test::MakeRecording(rig, {.waves = 150, .touches = 40, .responses = false, .seed = 8});
  const auto plain = SelfCalibrate(nominal, {}, recording);
  for (Sample& sample : recording.samples) {
    for (base::Vec3& B : sample.field_sensor_T) B = {1.02 * B.x, 1.02 * B.y, 1.02 * B.z};
  }
  const auto scaled = SelfCalibrate(nominal, {}, recording);
  ASSERT_TRUE(plain.ok()) << plain.error();
  ASSERT_TRUE(scaled.ok()) << scaled.error();
  EXPECT_NEAR(scaled->calibration.moment_Am2 / plain->calibration.moment_Am2, 1.02, 1e-3);
  EXPECT_NEAR(MeanGain(scaled->calibration), 1, 1e-4);
  EXPECT_LT(PositionError_m(plain->calibration, scaled->calibration), 0.05e-3);
}

TEST(CalibrationRecover, CoilAxesFixTheRotationThatTouchesLeaveOpen) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  sim::Rig rig(device, Uncalibrated(51, sim::NoiseMode::kUltraHigh));
  const Recording recording = test::MakeRecording(rig, {.waves = 150, .touches = 40, .seed = 9});
  const auto with = SelfCalibrate(nominal, device.coils, recording);
  const auto without = SelfCalibrate(nominal, {}, recording);
  ASSERT_TRUE(with.ok()) << with.error();
  ASSERT_TRUE(without.ok()) << without.error();
  EXPECT_LT(with->report.frame_rotation_rad, 1.2e-3);
  EXPECT_GT(without->report.frame_rotation_rad, 2e-3);
  EXPECT_LT(with->report.expected_error_m, without->report.expected_error_m);
  // Three directions that only tolerances hold: the rotation about the core.
  EXPECT_GE(without->report.weak_directions, with->report.weak_directions);
}

TEST(CalibrationRecover, ReportsParametersTheRecordingDidNotDetermine) {
  base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  sim::Rig rig(device, Uncalibrated(61, sim::NoiseMode::kUltraHigh));
  Recording rich = test::MakeRecording(rig, {.waves = 300, .touches = 80, .seed = 10});
  // Sensor 4's x axis is dead: its row of the gain stays at its tolerance.
  for (Sample& sample : rich.samples) sample.field_sensor_T[4].x = std::nan("");
  Options options;
  options.limits.saturated_max = 1;
  const auto outcome = SelfCalibrate(nominal, {}, {rich.samples, {}}, options);
  ASSERT_TRUE(outcome.ok()) << outcome.error();
  EXPECT_TRUE(Names(outcome->report.unfixed, "sensor 4 gain x"));
  EXPECT_FALSE(Names(outcome->report.unfixed, "sensor 3 gain x"));
  EXPECT_FALSE(Names(outcome->report.unfixed, "moment"));
  EXPECT_GT(outcome->report.weak_directions, 0);
  for (const Undetermined& one : outcome->report.unfixed) {
    EXPECT_LE(one.sigma, one.tolerance * 1.0001);
    EXPECT_FALSE(one.unit.empty());
  }
}

TEST(CalibrationRecover, OutliersAndFalseTouchesHaveLittleInfluence) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  sim::Rig rig(device, Uncalibrated(71, sim::NoiseMode::kUltraHigh));
  Recording recording = test::MakeRecording(rig, {.waves = 200, .touches = 60, .seed = 12});
  const auto clean = SelfCalibrate(nominal, device.coils, recording);
  for (std::size_t n = 0; n < 200; n += 20) recording.samples[n].field_sensor_T[n / 20 % 8].z += 3e-5;
  for (std::size_t n = 5; n < 200; n += 40) recording.samples[n].touches_hull = true;  // in the air
  const auto dirty = SelfCalibrate(nominal, device.coils, recording);
  ASSERT_TRUE(clean.ok()) << clean.error();
  ASSERT_TRUE(dirty.ok()) << dirty.error();
  EXPECT_GE(dirty->report.rejected, 8);
  EXPECT_LT(PositionError_m(clean->calibration, dirty->calibration), 0.15e-3);
}

// Two touches of five are rests a finger's breadth above the hull, as of a hand that hesitates.
Recording WithRestsInTheAir(sim::Rig& rig, std::size_t of_five, std::uint64_t seed) {
  Recording recording = test::MakeRecording(rig, {.waves = 200, .touches = 60, .seed = seed});
  sim::Random random(seed + 1);
  for (std::size_t n = 200; n < recording.samples.size(); ++n) {
    if (n % 5 >= of_five) continue;
    const sim::MagnetPose above = test::OnHull(rig, rig.DrawPose({.tilt_max_rad = 0.1}, random), 11.6e-3);
    Sample& sample = recording.samples[n];
    sample = test::TakeSample(rig, above, sample.t_s, random);
    sample.touches_hull = true;
  }
  return recording;
}

TEST(CalibrationRecover, RestsInTheAirAreNotCountedAsTouches) {
  const base::DeviceGeometry device = Device();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  for (const std::uint64_t seed : {73u, 74u, 75u}) {
    sim::Rig rig(device, Uncalibrated(seed, sim::NoiseMode::kUltraHigh));
    const auto clean = SelfCalibrate(nominal, device.coils, WithRestsInTheAir(rig, 0, 12));
    const auto dirty = SelfCalibrate(nominal, device.coils, WithRestsInTheAir(rig, 2, 12));
    ASSERT_TRUE(clean.ok()) << clean.error();
    ASSERT_TRUE(dirty.ok()) << dirty.error();
    EXPECT_EQ(dirty->report.rests_in_air, 24);
    EXPECT_EQ(dirty->report.touches, 36);
    EXPECT_LT(PositionError_m(clean->calibration, dirty->calibration), 0.15e-3);
  }
}

}  // namespace test_calibration_recover
}  // namespace omni::calibration
