// Recordings that would make a bad calibration are rejected, with the reason and the remedy.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "service/calibration/fit/self_calibration.h"
#include "service/magnetics/nominal.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::calibration {
namespace test_calibration_refuse {

class CalibrationRefuse : public ::testing::Test {
 protected:
  CalibrationRefuse() : device_(support::NominalDevice()), rig_(device_, Options()) {
    nominal_ = magnetics::NominalCalibration(device_);
    recording_ = test::MakeRecording(rig_, {.waves = 90, .touches = 25, .seed = 2});
  }

  static sim::RigOptions Options() {
    sim::RigOptions options{.seed = 17, .noise = sim::NoiseMode::kLowPower};
    options.sizes.sensor_position_m = 0.5e-3;
    return options;
  }

  std::string Why(const calibration::Options& options = {}) {
    const auto outcome = SelfCalibrate(nominal_, device_.coils, recording_, options);
    EXPECT_FALSE(outcome.ok());
    return outcome.ok() ? std::string() : outcome.error();
  }
  void Expect(const std::string& why, std::initializer_list<const char*> words) {
    EXPECT_EQ(why.rfind("calibration refused: ", 0), 0u) << why;
    for (const char* word : words) EXPECT_NE(why.find(word), std::string::npos) << word << " not in: " << why;
  }

  base::DeviceGeometry device_;
  sim::Rig rig_;
  base::Calibration nominal_;
  Recording recording_;
};

TEST_F(CalibrationRefuse, SoundRecordingIsAccepted) {
  const auto outcome = SelfCalibrate(nominal_, device_.coils, recording_);
  EXPECT_TRUE(outcome.ok()) << outcome.error();
}

TEST_F(CalibrationRefuse, TooFewPosesOrTouches) {
  for (Sample& sample : recording_.samples) sample.touches_hull = false;
  Expect(Why(), {"0 touches", "at least 20", "touch it in more places"});
  recording_.samples.resize(30);
  Expect(Why(), {"30 usable poses", "at least 80", "longer"});
  recording_.samples.clear();
  Expect(Why(), {"0 usable poses"});
}

TEST_F(CalibrationRefuse, TouchesInTheAir) {
  sim::Random random(5);
  int touches = 0;
  for (Sample& sample : recording_.samples) {
    if (!sample.touches_hull || ++touches <= 8) continue;
    const sim::MagnetPose pose = rig_.DrawPose({.radius_max_m = 0.07, .tilt_max_rad = 0.3}, random);
    sample = test::TakeSample(rig_, test::OnHull(rig_, pose, random.Uniform(4e-3, 30e-3)), sample.t_s, random);
    sample.touches_hull = true;
  }
  Expect(Why(), {"touches lie on the hull", "at least 12", "not above it"});
}

TEST_F(CalibrationRefuse, PenHeldStillOrOnOneSideOnly) {
  sim::Random random(4);
  const sim::MagnetPose pose = rig_.DrawPose({}, random);
  for (Sample& sample : recording_.samples) {
    const bool touches = sample.touches_hull;
    sample = test::TakeSample(rig_, pose, sample.t_s, random);
    sample.touches_hull = touches;
  }
  Expect(Why(), {"the pen moved by", "wave it"});
  for (Sample& sample : recording_.samples) {
    const bool touches = sample.touches_hull;
    const sim::MagnetPose high = rig_.DrawPose({.elevation_min_rad = 1.2}, random);
    sample = test::TakeSample(rig_, high, sample.t_s, random);
    sample.touches_hull = touches;
  }
  Expect(Why(), {"upper hemisphere", "on all sides"});
}

TEST_F(CalibrationRefuse, ReversedMagnet) {
  for (Sample& sample : recording_.samples) {
    for (base::Vec3& B : sample.field_sensor_T) B = {-B.x, -B.y, -B.z};
  }
  recording_.responses.clear();
  Expect(Why(), {"wrong way round", "turn it over"});
}

TEST_F(CalibrationRefuse, MagnetWeakerThanInTheDeviceFile) {
  for (Sample& sample : recording_.samples) {
    for (base::Vec3& B : sample.field_sensor_T) B = {0.75 * B.x, 0.75 * B.y, 0.75 * B.z};
  }
  Expect(Why(), {"weaker than in the device file", "right magnet"});
}

TEST_F(CalibrationRefuse, SaturatedOrSilentSensors) {
  for (std::size_t n = 0; n < recording_.samples.size(); n += 2) {
    recording_.samples[n].field_sensor_T[n % 8].y = std::numeric_limits<double>::quiet_NaN();
  }
  Expect(Why(), {"saturated or silent in 50 %", "at most 30 %"});
}

TEST_F(CalibrationRefuse, SecondMagnetSwappedSensorsOrWrongUnits) {
  Recording original = recording_;
  sim::Random random(6);
  for (Sample& sample : recording_.samples) {  // another pen, elsewhere
    const sim::MagnetPose other = rig_.DrawPose({.radius_min_m = 0.1, .radius_max_m = 0.14}, random);
    const auto field = rig_.Readings(&other, {});
    for (std::size_t i = 0; i < field.size(); ++i) {
      base::Vec3& B = sample.field_sensor_T[i];
      B = {B.x + field[i].x, B.y + field[i].y, B.z + field[i].z};
    }
  }
  Expect(Why(), {"readings", "magnet"});
  recording_ = original;
  for (Sample& sample : recording_.samples) std::swap(sample.field_sensor_T[1], sample.field_sensor_T[6]);
  Expect(Why(), {"fit no pose", "sensors (order, axes)"});
  recording_ = original;
  for (Sample& sample : recording_.samples) {  // gauss for tesla
    for (base::Vec3& B : sample.field_sensor_T) B = {1e4 * B.x, 1e4 * B.y, 1e4 * B.z};
  }
  EXPECT_FALSE(Why().empty());
}

TEST_F(CalibrationRefuse, ReversedOrWeakCoilMagnetAtRestOrMissingMap) {
  Recording original = recording_;
  for (CoilResponse& response : recording_.responses) {
    for (std::size_t row = 0; row < 3; ++row) response.map_sensor_T_A[3 * row + 1] *= -1;
  }
  Expect(Why(), {"coil y acts backwards", "swap its leads"});
  recording_ = original;
  for (CoilResponse& response : recording_.responses) {
    for (double& entry : response.map_sensor_T_A) entry *= 0.5;
  }
  Expect(Why(), {"coil x acts on sensor 0", "70 to 140 %"});
  recording_ = original;
  recording_.responses[3].background_sensor_T.z += 1e-3;
  Expect(Why(), {"sensor 3", "at rest", "take the pen"});
  recording_ = original;
  recording_.responses.pop_back();
  Expect(Why(), {"7 current maps for 8 sensors"});
}

TEST_F(CalibrationRefuse, SwappedSensorsAreIdentifiedByTheirCurrentMaps) {
  const Recording original = recording_;
  for (std::size_t a = 0; a < 8; ++a) {
    for (std::size_t b = a + 1; b < 8; ++b) {
      std::swap(recording_.responses[a], recording_.responses[b]);
      Expect(Why(), {("sensors " + std::to_string(a) + " and " + std::to_string(b) + " are swapped").c_str(),
                     "exchange their cables or addresses"});
      recording_ = original;
    }
  }
}

TEST_F(CalibrationRefuse, NonFiniteOrMalformedSamples) {
  Recording original = recording_;
  recording_.samples[7].t_s = std::numeric_limits<double>::infinity();
  Expect(Why(), {"samples[7]", "not a number"});
  recording_ = original;
  recording_.samples[8].noise_scale = 0;
  Expect(Why(), {"samples[8].noise_scale"});
  recording_ = original;
  recording_.samples[9].field_sensor_T.pop_back();
  Expect(Why(), {"samples[9]", "7 sensors"});
  recording_ = original;
  recording_.responses[2].map_sensor_T_A[4] = std::numeric_limits<double>::quiet_NaN();
  Expect(Why(), {"sensor 2", "not a number"});
  recording_ = original;
  nominal_.sensor_noise_T[1] = 0;
  Expect(Why(), {"sensor_noise_T"});
}

TEST_F(CalibrationRefuse, SensorFarFromItsNominalPosition) {
  recording_.responses.clear();
  nominal_.sensors[5].position_base_m.x += 8e-3;
  Expect(Why(), {"tolerances"});
}

}  // namespace test_calibration_refuse
}  // namespace omni::calibration
