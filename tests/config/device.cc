// Device files: what is read, and the error of each mistake.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>

#include "service/config/files/device_file.h"
#include "tests/support/process/manifest_text.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::config {
namespace test_config_device {

std::string Manifest() { return test::ManifestText("device/omni.toml"); }

// The manifest with the first occurrence of `from` replaced.
std::string Changed(const std::string& from, const std::string& to) { return test::Replaced(Manifest(), from, to); }

std::string ErrorOf(const std::string& text) {
  const auto device = ParseDevice(text, "test.toml");
  EXPECT_FALSE(device.ok());
  return device.ok() ? std::string() : device.error();
}

void ExpectMentions(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

int LineOf(const std::string& text, const std::string& part) {
  return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(text.find(part)), '\n'));
}

TEST(ConfigDevice, ReadsTheManifest) {
  const auto device = LoadDeviceFile(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  ASSERT_TRUE(device.ok()) << device.error();
  EXPECT_EQ(device->name, "omni");
  EXPECT_DOUBLE_EQ(device->magnet.radius_m, 0.015);
  EXPECT_DOUBLE_EQ(device->magnet.tip_offset_m, 0.005);
  EXPECT_DOUBLE_EQ(device->core_kappa, 0.997);
  EXPECT_DOUBLE_EQ(device->hull_radius_m, 0.0375);
  EXPECT_DOUBLE_EQ(device->sensor_noise_T[2], 1.0e-6);
  EXPECT_EQ(device->sensors[1].position_base_m, (base::Vec3{0, 0.060, -0.075}));
  EXPECT_EQ(device->sensors[7].position_base_m.z, -0.095);
  EXPECT_EQ(device->sensors[0].orientation_base_sensor, (base::Quat{1, 0, 0, 0}));
  EXPECT_EQ(device->coils[2].axis_base, (base::Vec3{0, 0, 1}));
  EXPECT_EQ(device->coils[0].turns, 156);
  EXPECT_EQ(device->coils[2].turns, 160);
  EXPECT_DOUBLE_EQ(device->force_max_N, 2);
  EXPECT_DOUBLE_EQ(device->supply_V, 18);
}

// Half a ball between the magnet's face and the tip, as the pen's drawing has it.
TEST(ConfigDevice, NibIsAsLongAsItsRadius) {
  EXPECT_EQ(NibRadius_m(DefaultDevice().magnet), 0.0015);
  base::MagnetGeometry magnet = DefaultDevice().magnet;
  magnet.tip_offset_m = magnet.half_height_m;
  EXPECT_EQ(NibRadius_m(magnet), 0) << "a bare magnet";
  magnet.tip_offset_m = 0;
  EXPECT_EQ(NibRadius_m(magnet), 0) << "not given";
  magnet.tip_offset_m = 0.08;
  EXPECT_EQ(NibRadius_m(magnet), 0) << "a rod";
  magnet = {.shape = base::MagnetShape::kSphere, .radius_m = 0.004, .tip_offset_m = 0.005};
  EXPECT_EQ(NibRadius_m(magnet), 0.001);
}

TEST(ConfigDevice, HeatTableIsOptionalButMustBeComplete) {
  const auto device = ParseDevice(Changed("body_J_K = 94.2", "body_J_K = 300"), "test.toml");
  ASSERT_TRUE(device.ok()) << device.error();
  EXPECT_DOUBLE_EQ(device->heat.body_J_K, 300);
  EXPECT_DOUBLE_EQ(device->heat.copper_to_body_W_K, 1.048);
  const auto without = ParseDevice(Manifest().substr(0, Manifest().find("[heat]")), "test.toml");
  ASSERT_TRUE(without.ok()) << without.error();
  EXPECT_DOUBLE_EQ(without->heat.copper_J_K, base::HeatGeometry{}.copper_J_K);
  ExpectMentions(ErrorOf(Changed("body_J_K = 94.2", "")), {"test.toml", "heat.body_J_K"});
  ExpectMentions(ErrorOf(Changed("air_C = 24.0", "air_C = 297")), {"heat.air_C", "297"});
}

std::vector<double> NumbersOf(const base::DeviceGeometry& device) {
  std::vector<double> numbers{device.magnet.radius_m,
                              device.magnet.half_height_m,
                              device.magnet.remanence_T,
                              device.magnet.mass_kg,
                              device.magnet.tip_offset_m,
                              device.core_radius_m,
                              device.core_kappa,
                              device.hull_radius_m,
                              device.sensor_range_T,
                              device.sensor_lsb_T,
                              device.current_max_A,
                              device.current_slew_A_s,
                              device.force_max_N,
                              device.temperature_max_C,
                              device.temperature_derate_C,
                              device.supply_V,
                              device.heat.copper_J_K,
                              device.heat.body_J_K,
                              device.heat.copper_to_body_W_K,
                              device.heat.body_to_air_W_K,
                              device.heat.air_C};
  numbers.insert(numbers.end(), device.sensor_noise_T.begin(), device.sensor_noise_T.end());
  for (const base::SensorGeometry& sensor : device.sensors) {
    const auto& [p, q] = sensor;
    numbers.insert(numbers.end(), {p.x, p.y, p.z, q.w, q.x, q.y, q.z});
  }
  for (const base::CoilGeometry& coil : device.coils) {
    numbers.insert(numbers.end(), {coil.axis_base.x, coil.axis_base.y, coil.axis_base.z, double(coil.turns),
                                   double(coil.layers), coil.shell_radius_min_m, coil.shell_radius_max_m,
                                   coil.band_half_width_m, coil.resistance_20C_ohm, coil.inductance_H});
  }
  return numbers;
}

// Tests that read no file write it out by hand: a base that was changed in one place only would be tested as the old
// one.
TEST(ConfigDevice, NominalDeviceOfTestsIsTheManifest) {
  const auto device = LoadDeviceFile(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  ASSERT_TRUE(device.ok());
  const std::vector<double> numbers = NumbersOf(*device), nominal = NumbersOf(support::NominalDevice());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_NEAR(nominal[i], numbers[i], 1e-9 * std::abs(numbers[i]) + 1e-15) << "number " << i;
  EXPECT_EQ(device->magnet.shape, support::NominalDevice().magnet.shape);
  // The twin's sensors are linear over the share of their range that their data sheet says.
  EXPECT_EQ(device->sensor_range_T, 1.6e-3) << "another sensor: its share is kLinearShare of sim/fields/truth_model.cc";
}

TEST(ConfigDevice, BuiltInIsTheManifest) {
  const auto device = LoadDeviceFile(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  ASSERT_TRUE(device.ok());
  const base::DeviceGeometry& built_in = DefaultDevice();
  EXPECT_EQ(built_in.name, device->name);
  EXPECT_EQ(built_in.sensor_noise_T, device->sensor_noise_T);
  EXPECT_EQ(built_in.current_slew_A_s, device->current_slew_A_s);
  for (std::size_t i = 0; i < built_in.sensors.size(); ++i) {
    EXPECT_EQ(built_in.sensors[i].position_base_m, device->sensors[i].position_base_m);
  }
  for (std::size_t i = 0; i < built_in.coils.size(); ++i) {
    EXPECT_EQ(built_in.coils[i].resistance_20C_ohm, device->coils[i].resistance_20C_ohm);
    EXPECT_EQ(built_in.coils[i].inductance_H, device->coils[i].inductance_H);
  }
}

TEST(ConfigDevice, OutOfRangeErrorNamesFileLineKeyValueAndRange) {
  const std::string text = Changed("radius_m = 0.015 ", "radius_m = 15 ");  // millimetres
  ExpectMentions(ErrorOf(text), {"test.toml:", "magnet.radius_m", "15", "[0.001, 0.05]"});
  ExpectMentions(ErrorOf(text), {(":" + std::to_string(LineOf(text, "radius_m = 15")) + ":").c_str()});
}

TEST(ConfigDevice, RejectsNonFiniteNumbers) {
  ExpectMentions(ErrorOf(Changed("force_max_N = 2.0", "force_max_N = nan")), {"limits.force_max_N", "nan"});
  ExpectMentions(ErrorOf(Changed("supply_V = 18.0", "supply_V = inf")), {"limits.supply_V", "inf"});
  ExpectMentions(ErrorOf(Changed("[0.060, 0.0, -0.075]", "[0.060, nan, -0.075]")),
                 {"sensors[0].position_base_m[1]", "nan"});
}

TEST(ConfigDevice, RejectsWrongTypes) {
  ExpectMentions(ErrorOf(Changed("remanence_T = 1.3", "remanence_T = \"1.3\"")),
                 {"magnet.remanence_T", "string", "[0.1, 1.6]"});
  ExpectMentions(ErrorOf(Changed("turns = 156", "turns = 156.5")), {"coils[0].turns", "integer"});
  ExpectMentions(ErrorOf(Changed("[0.060, 0.0, -0.075]", "[0.060, 0.0]")), {"sensors[0].position_base_m", "3 numbers"});
  ExpectMentions(ErrorOf(Changed("name = \"omni\"", "name = 3")), {"name", "text"});
  ExpectMentions(ErrorOf(Changed("[hull]", "[[hull]]")), {"hull", "table"});
}

TEST(ConfigDevice, RejectsUnknownAndMissingKeys) {
  ExpectMentions(ErrorOf(Changed("mass_kg", "mass_g")), {"magnet.mass_kg", "missing"});
  ExpectMentions(ErrorOf(Changed("mass_kg = 0.038", "mass_kg = 0.038\ncolour = \"red\"")),
                 {"magnet.colour", "unknown", "mass_kg"});
  ExpectMentions(ErrorOf(Manifest() + "\n[spare]\nx = 1\n"), {"spare", "unknown"});
  ExpectMentions(ErrorOf(Changed("[core]", "[kern]")), {"core", "missing"});
}

TEST(ConfigDevice, RejectsWrongCountsOfSensorsAndCoils) {
  const std::string sensor =
      "[[sensors]]\nposition_base_m = [0.01, 0.05, -0.075]\norientation_base_sensor = [1, 0, 0, 0]\n";
  ExpectMentions(ErrorOf(Changed("[[sensors]]", sensor + "[[sensors]]")), {"sensors", "9", "8"});
  std::string text = Manifest();
  text.erase(text.rfind("[[coils]]"), text.find("[limits]") - text.rfind("[[coils]]"));
  ExpectMentions(ErrorOf(text), {"coils", "2", "3"});
}

TEST(ConfigDevice, DirectionsAreNormalisedOrRejected) {
  const auto device = ParseDevice(Changed("axis_base = [1.0, 0.0, 0.0]", "axis_base = [1.0, 0.005, 0.0]"), "t");
  ASSERT_TRUE(device.ok()) << device.error();
  const base::Vec3& axis = device->coils[0].axis_base;
  EXPECT_NEAR(Norm(axis), 1, 1e-15);
  ExpectMentions(ErrorOf(Changed("axis_base = [1.0, 0.0, 0.0]", "axis_base = [0.5, 0.0, 0.0]")),
                 {"coils[0].axis_base", "length"});
  ExpectMentions(ErrorOf(Changed("[1.0, 0.0, 0.0, 0.0]", "[0.0, 0.0, 0.0, 0.0]")),
                 {"orientation_base_sensor", "length"});
}

TEST(ConfigDevice, RejectsContradictoryGeometry) {
  ExpectMentions(ErrorOf(Changed("[0.060, 0.0, -0.075]", "[0.001, 0.0, -0.01]")), {"sensors[0]", "core_radius_m"});
  ExpectMentions(ErrorOf(Changed("[0.0, 0.060, -0.075]", "[0.060, 0.0, -0.075]")),
                 {"sensors[0]", "sensors[1]", "same"});
  ExpectMentions(ErrorOf(Changed("hull_radius_m = 0.0375", "hull_radius_m = 0.01")),
                 {"hull_radius_m", "core_radius_m"});
  ExpectMentions(ErrorOf(Changed("temperature_derate_C = 60.0", "temperature_derate_C = 80.0")),
                 {"temperature_derate_C", "temperature_max_C"});
  // More counts than 16 bits have; up to there it is read.
  ExpectMentions(ErrorOf(Changed("sensor_range_T = 1.6e-3", "sensor_range_T = 1.92e-3")),
                 {"sensor_range_T", "32768 times sensor.sensor_lsb_T"});
  EXPECT_TRUE(ParseDevice(Changed("sensor_range_T = 1.6e-3", "sensor_range_T = 1.91e-3"), "test.toml").ok());
  ExpectMentions(ErrorOf(Changed("shell_radius_max_m = 0.0325", "shell_radius_max_m = 0.05")),
                 {"shell_radius_max_m", "hull_radius_m"});
  ExpectMentions(ErrorOf(Changed("axis_base = [0.0, 1.0, 0.0]", "axis_base = [1.0, 0.0, 0.0]")), {"axis_base"});
}

TEST(ConfigDevice, SyntaxErrorsNameTheLine) {
  ExpectMentions(ErrorOf("name = \"x\"\n[magnet\n"), {"test.toml:2"});
  ExpectMentions(ErrorOf(""), {"name", "missing"});
  ExpectMentions(ErrorOf(Changed("mass_kg = 0.038", "mass_kg = 0.038\nmass_kg = 0.04")), {"mass_kg"});
}

TEST(ConfigDevice, ErrorsContainNoControlCharacters) {
  const std::string error = ErrorOf(Changed("mass_kg = 0.038", "mass_kg = 0.038\n\"\\u001b[2J\" = 1"));
  EXPECT_EQ(error.find('\033'), std::string::npos);
}

TEST(ConfigDevice, RejectsMissingNonRegularAndHugeFiles) {
  const test::TempFolder folder;
  ExpectMentions(LoadDeviceFile(folder.Path("none.toml")).error(), {"none.toml", "cannot be read", "No such file"});
  ExpectMentions(LoadDeviceFile(folder.Path(".")).error(), {"regular file"});
  ASSERT_EQ(::mkfifo(folder.Path("pipe.toml").c_str(), 0600), 0);  // must not wait for a writer
  ExpectMentions(LoadDeviceFile(folder.Path("pipe.toml")).error(), {"regular file"});
  folder.Write("huge.toml", std::string(2 << 20, '#'));
  ExpectMentions(LoadDeviceFile(folder.Path("huge.toml")).error(), {"longer than"});
}

}  // namespace test_config_device
}  // namespace omni::config
