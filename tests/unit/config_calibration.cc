// Calibration files: what is kept, and what each mistake is told.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "service/config/calibration_file.h"
#include "tests/support/nominal_device.h"
#include "tests/support/temp_folder.h"

namespace omni::config {
namespace {

CalibrationFile Example() {
  const base::DeviceGeometry device = support::NominalDevice();
  CalibrationFile file;
  file.serial = "twin-3";
  file.date = "2026-11-21T09:00:00Z";
  file.quality = {.expected_error_mm = 0.08,
                  .frame_rotation_deg = 0.05,
                  .chi2_per_dof = 1.01,
                  .coverage = 0.95,
                  .samples = 500,
                  .touches = 100,
                  .unfixed = 2};
  file.calibration.device = device.name;
  file.calibration.moment_Am2 = 5.0123456789012345;
  file.calibration.core_kappa = 0.9971;
  for (std::size_t i = 0; i < device.sensors.size(); ++i) {
    base::SensorCalibration sensor;
    sensor.position_base_m = device.sensors[i].position_base_m;
    sensor.position_base_m.x += 1e-3 / 3 * static_cast<double>(i);
    for (std::size_t e = 0; e < 9; ++e) {
      sensor.gain_sensor_base[e] = (e % 4 == 0 ? 1.0 : 0.0) + 0.01 / (1.0 + static_cast<double>(e + i));
      sensor.current_map_T_A[e] = 1e-5 / (1.0 + static_cast<double>(e));
    }
    sensor.background_sensor_T = {2e-5, -1.1e-5, 4.3e-5};
    file.calibration.sensors.push_back(sensor);
  }
  return file;
}

std::string Text() { return WriteCalibration(Example(), support::NominalDevice()); }

std::string Changed(const std::string& from, const std::string& to) {
  std::string text = Text();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string ErrorOf(const std::string& text, const std::string& serial = "twin-3") {
  const auto parsed = ParseCalibration(text, "test.toml", support::NominalDevice(), serial);
  EXPECT_FALSE(parsed.ok());
  return parsed.ok() ? std::string() : parsed.error();
}

void ExpectMentions(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

TEST(ConfigCalibration, ComesBackToTheLastBit) {
  const base::DeviceGeometry device = support::NominalDevice();
  const CalibrationFile written = Example();
  const auto read = ParseCalibration(Text(), "test.toml", device, "twin-3");
  ASSERT_TRUE(read.ok()) << read.error();
  ASSERT_EQ(read->calibration.sensors.size(), written.calibration.sensors.size());
  for (std::size_t i = 0; i < written.calibration.sensors.size(); ++i) {
    const base::SensorCalibration& a = written.calibration.sensors[i];
    const base::SensorCalibration& b = read->calibration.sensors[i];
    EXPECT_EQ(a.position_base_m, b.position_base_m);
    EXPECT_EQ(a.gain_sensor_base, b.gain_sensor_base);
    EXPECT_EQ(a.current_map_T_A, b.current_map_T_A);
    EXPECT_EQ(a.background_sensor_T, b.background_sensor_T);
  }
  EXPECT_EQ(read->calibration.moment_Am2, written.calibration.moment_Am2);
  EXPECT_EQ(read->calibration.core_kappa, written.calibration.core_kappa);
  EXPECT_EQ(read->quality.touches, 100);
  EXPECT_EQ(read->quality.expected_error_mm, 0.08);
  EXPECT_EQ(read->date, written.date);
  // Not in the file: as the device has them.
  EXPECT_EQ(read->calibration.magnet.radius_m, device.magnet.radius_m);
  EXPECT_EQ(read->calibration.hull_radius_m, device.hull_radius_m);
  EXPECT_EQ(read->calibration.sensor_noise_T, device.sensor_noise_T);
}

TEST(ConfigCalibration, BelongsToOneGeometryOneBaseAndOneFormat) {
  ExpectMentions(ErrorOf(Changed("format = 1", "format = 2")), {"test.toml", "format = 2", "omni calibrate"});
  ExpectMentions(ErrorOf(Text(), "twin-4"), {"serial", "twin-3", "twin-4", "omni calibrate"});
  base::DeviceGeometry other = support::NominalDevice();
  other.sensors[2].position_base_m.z += 1e-4;
  const auto parsed = ParseCalibration(Text(), "test.toml", other, "twin-3");
  ASSERT_FALSE(parsed.ok());
  ExpectMentions(parsed.error(), {"device_hash", "another geometry", "omni calibrate"});
}

TEST(ConfigCalibration, HashSeesWhatMattersOnly) {
  const base::DeviceGeometry device = support::NominalDevice();
  const std::uint64_t hash = GeometryHash(device);
  base::DeviceGeometry limits = device;
  limits.force_max_N = 1;
  limits.sensor_noise_T[0] *= 2;
  EXPECT_EQ(GeometryHash(limits), hash);
  base::DeviceGeometry magnet = device;
  magnet.magnet.remanence_T = 1.31;
  EXPECT_NE(GeometryHash(magnet), hash);
  base::DeviceGeometry turned = device;
  turned.sensors[0].orientation_base_sensor = {0, 1, 0, 0};
  EXPECT_NE(GeometryHash(turned), hash);
  base::DeviceGeometry coil = device;
  coil.coils[1].turns += 1;
  EXPECT_NE(GeometryHash(coil), hash);
}

TEST(ConfigCalibration, RefusesWhatIsNoNumberOrOutOfRange) {
  ExpectMentions(ErrorOf(Changed("core_kappa = 0.99", "core_kappa = nan # 0.99")), {"core_kappa", "test.toml:"});
  ExpectMentions(ErrorOf(Changed("moment_Am2 = 5.01", "moment_Am2 = 50.1")), {"moment_Am2", "magnet"});
  ExpectMentions(ErrorOf(Changed("position_base_m = [0.05", "position_base_m = [0.08")),
                 {"sensors[0].position_base_m", "drawing"});
  ExpectMentions(ErrorOf(Changed("gain_sensor_base = [1.0", "gain_sensor_base = [1001.0")), {"gain_sensor_base[0]"});
  ExpectMentions(ErrorOf(Changed("background_sensor_T = [2", "background_sensor_T = [-inf, 2")),
                 {"background_sensor_T"});
  ExpectMentions(ErrorOf(Changed("touches = 100", "touches = 100\nfriend = 1")), {"quality.friend"});
  ExpectMentions(ErrorOf(Changed("[[sensors]]", "[[sensor]]")), {"sensors", "8 tables"});
  ExpectMentions(ErrorOf(Text().substr(0, 700)), {"test.toml"});
  ExpectMentions(ErrorOf(""), {"format is missing"});
}

TEST(ConfigCalibration, ProgramsTakeTheFileThatFitsAndSayWhyNot) {
  const test::TempFolder folder;
  const base::DeviceGeometry device = support::NominalDevice();
  const std::string path = folder.Path("below/calibration.toml");
  const base::Status saved = SaveCalibrationFile(path, Example(), device);
  ASSERT_TRUE(saved.ok()) << saved.error();
  EXPECT_FALSE(std::ifstream(path + ".new").is_open());

  const CalibrationChoice used = ChooseCalibration(path, device, "twin-3");
  EXPECT_TRUE(used.file.has_value());
  EXPECT_TRUE(used.problem.empty());

  const CalibrationChoice refused = ChooseCalibration(path, device, "twin-9");
  EXPECT_FALSE(refused.file.has_value());
  ExpectMentions(refused.problem, {"calibration.toml", "twin-9", "as drawn"});

  const CalibrationChoice missing = ChooseCalibration(folder.Path("none.toml"), device, "twin-3");
  EXPECT_FALSE(missing.file.has_value());
  ExpectMentions(missing.problem, {"none.toml", "cannot be read"});
}

TEST(ConfigCalibration, SaysWhereItCannotWrite) {
  const test::TempFolder folder;
  folder.Write("file", "x");
  const base::Status saved =
      SaveCalibrationFile(folder.Path("file/calibration.toml"), Example(), support::NominalDevice());
  ASSERT_FALSE(saved.ok());
  ExpectMentions(saved.error(), {"file/calibration.toml", "cannot be written"});
}

}  // namespace
}  // namespace omni::config
