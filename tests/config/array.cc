// Array files: what is read, and the error of each mistake.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "service/config/files/array_file.h"

namespace omni::config {
namespace test_config_array {

const char* const kFour = R"(format = "omni-array 1"
name = "patch"

[magnet]
shape = "cylinder"
radius_m = 0.005
half_height_m = 0.005
moment_Am2 = 0.8

[sensor]
sensor_noise_T = [1e-6, 1e-6, 2e-6]
sensor_range_T = 0.05

[[sensors]]
position_base_m = [0.6, -0.18, 0.68]

[[sensors]]
position_base_m = [0.62, -0.18, 0.68]
orientation_base_sensor = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476]
gain = 1.1

[[sensors]]
position_base_m = [0.64, -0.18, 0.68]
rotation_base_sensor_rad = [0.0, 0.0, 1.5707963267948966]
gain = [1.0, 2.0, 3.0]
background_sensor_T = [1e-5, 0.0, -2e-5]

[[sensors]]
position_base_m = [0.66, -0.18, 0.68]
gain_sensor_base = [1.0, 0.1, 0.0,  0.0, 1.0, 0.0,  0.0, 0.0, 1.0]
)";

// `kFour` with the first occurrence of `from` replaced.
std::string Changed(const std::string& from, const std::string& to) {
  std::string text = kFour;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void ExpectError(const std::string& text, std::initializer_list<const char*> words) {
  const auto array = ParseArray(text, "test.toml");
  ASSERT_FALSE(array.ok()) << text;
  for (const char* word : words)
    EXPECT_NE(array.error().find(word), std::string::npos) << word << ": " << array.error();
}

TEST(ConfigArray, ReadsEverySensorOrientationFormat) {
  const auto file = ParseArray(kFour, "test.toml");
  ASSERT_TRUE(file.ok()) << file.error();
  const base::Calibration& array = file->calibration;
  EXPECT_EQ(array.device, "patch");
  EXPECT_DOUBLE_EQ(array.moment_Am2, 0.8);
  EXPECT_DOUBLE_EQ(array.magnet.half_height_m, 0.005);
  EXPECT_DOUBLE_EQ(array.sensor_range_T, 0.05);
  EXPECT_EQ(array.core_radius_m, 0);
  ASSERT_EQ(array.sensors.size(), 4U);
  EXPECT_EQ(array.sensors[0].gain_sensor_base, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  // Sensor x looks along base y: R_SB (0, 1, 0) = (1, 0, 0).
  EXPECT_NEAR(array.sensors[1].gain_sensor_base[1], 1.1, 1e-12);
  EXPECT_NEAR(array.sensors[1].gain_sensor_base[3], -1.1, 1e-12);
  EXPECT_NEAR(array.sensors[2].gain_sensor_base[1], 1, 1e-12);
  EXPECT_NEAR(array.sensors[2].gain_sensor_base[3], -2, 1e-12);
  EXPECT_NEAR(array.sensors[2].gain_sensor_base[8], 3, 1e-12);
  EXPECT_DOUBLE_EQ(array.sensors[2].background_sensor_T.z, -2e-5);
  EXPECT_DOUBLE_EQ(array.sensors[3].gain_sensor_base[1], 0.1);
  EXPECT_TRUE(IsArrayText(kFour));
}

TEST(ConfigArray, BodiesCoilsAndMapsAreOptional) {
  const std::string bodies =
      "[core]\ncore_radius_m = 0.015\n[hull]\nhull_radius_m = 0.0375\n[volume]\nmin_base_m = [-0.1, -0.1, 0.0]\n"
      "max_base_m = [0.1, 0.1, 0.2]\n";
  std::string coils;
  for (const char* axis : {"[1.0, 0.0, 0.0]", "[0.0, 1.0, 0.0]", "[0.0, 0.0, 1.0]"}) {
    coils += std::string("[[coils]]\naxis_base = ") + axis +
             "\nturns = 156\nlayers = 6\nshell_radius_min_m = 0.015\nshell_radius_max_m = 0.0325\n"
             "band_half_width_m = 0.0112\n";
  }
  const auto file = ParseArray(kFour + bodies + coils, "t");
  ASSERT_TRUE(file.ok()) << file.error();
  EXPECT_DOUBLE_EQ(file->calibration.core_radius_m, 0.015);
  EXPECT_DOUBLE_EQ(file->calibration.core_kappa, 1);
  EXPECT_DOUBLE_EQ(file->calibration.hull_radius_m, 0.0375);
  EXPECT_DOUBLE_EQ(file->calibration.volume_max_base_m.z, 0.2);
  ASSERT_EQ(file->coils.size(), 3U);
  EXPECT_EQ(file->coils[1].turns, 156);
  const std::string map = "current_map_T_A = [1e-5, 0.0, 0.0, 0.0, 1e-5, 0.0, 0.0, 0.0, 1e-5]\n[[sensors]]\n";
  const auto mapped = ParseArray(Changed("[[sensors]]\nposition_base_m = [0.62", map + "position_base_m = [0.62"), "t");
  ASSERT_TRUE(mapped.ok()) << mapped.error();
  EXPECT_DOUBLE_EQ(mapped->calibration.sensors[0].current_map_T_A[4], 1e-5);
  const auto sphere =
      ParseArray(Changed("shape = \"cylinder\"\nradius_m = 0.005\nhalf_height_m = 0.005\nmoment_Am2 = 0.8",
                         "shape = \"sphere\"\nradius_m = 0.005\nremanence_T = 1.2"),
                 "t");
  ASSERT_TRUE(sphere.ok()) << sphere.error();
  EXPECT_EQ(sphere->calibration.magnet.shape, base::MagnetShape::kSphere);
  EXPECT_EQ(sphere->calibration.moment_Am2, 0);
}

TEST(ConfigArray, ErrorsNameKeyAndValue) {
  ExpectError(Changed("position_base_m = [0.6,", "position_base_m = [600,"), {"sensors[0].position_base_m[0]", "600"});
  ExpectError(Changed("radius_m = 0.005", "radius_m = 5"), {"magnet.radius_m", "5", "[0.0001, 0.2]"});
  ExpectError(Changed("moment_Am2 = 0.8", "moment_Am2 = nan"), {"moment_Am2", "nan"});
  ExpectError(Changed("moment_Am2 = 0.8", "moment_Am2 = 0.8\nremanence_T = 1.3"), {"either", "moment_Am2"});
  ExpectError(Changed("moment_Am2 = 0.8", ""), {"moment_Am2", "remanence_T"});
  ExpectError(Changed("omni-array 1", "omni-array 2"), {"format", "omni-array 1"});
  ExpectError(Changed("format = \"omni-array 1\"", ""), {"format", "missing"});
  ExpectError(Changed("gain = 1.1", "gian = 1.1"), {"gian", "unknown"});
  ExpectError(Changed("gain = 1.1", "gain = 0"), {"sensors[1].gain", "axis 0"});
  ExpectError(Changed("gain = [1.0, 2.0, 3.0]", "gain = [1.0, 2.0]"), {"sensors[2].gain", "3 numbers"});
  ExpectError(Changed("gain = 1.1", "rotation_base_sensor_rad = [0.0, 0.0, 1.0]"), {"exclude each other"});
  ExpectError(Changed("[0.7071067811865476, 0.0", "[0.9, 0.0"), {"orientation_base_sensor", "length"});
  ExpectError(Changed("rotation_base_sensor_rad = [0.0, 0.0, 1.5707963267948966]",
                      "rotation_base_sensor_rad = [0.0, 0.0, 90.0]"),
              {"rotation_base_sensor_rad", "90"});
  ExpectError(
      Changed("[0.62, -0.18, 0.68]\norientation_base_sensor = [0.7071067811865476, 0.0, 0.0, 0.7071067811865476]"
              "\ngain = 1.1",
              "[0.6, -0.18, 0.68]"),
      {"sensors[0]", "sensors[1]", "same position"});
  ExpectError(std::string(kFour) + "[core]\ncore_radius_m = 0.96\n", {"sensors[0]", "core"});
  ExpectError(std::string(kFour) + "[volume]\nmin_base_m = [0.0, 0.0, 0.0]\nmax_base_m = [0.1, -0.1, 0.1]\n",
              {"volume.min_base_m"});
  std::string three = kFour;
  three.erase(three.rfind("[[sensors]]"));
  ExpectError(three, {"sensors", "3", "4 to 64"});
  EXPECT_FALSE(IsArrayText("name = \"omni\""));
  EXPECT_FALSE(IsArrayText("format = "));
}

TEST(ConfigArray, WriteThenParseRoundTrips) {
  auto file = ParseArray(std::string(kFour) + "[core]\ncore_radius_m = 0.015\ncore_kappa = 0.99\n", "t");
  ASSERT_TRUE(file.ok()) << file.error();
  base::Calibration& array = file->calibration;
  array.sensors[1].current_map_T_A = {1e-5, 2e-6, 0, 0.1 / 3, 0, 0, 0, 0, 1e-300};
  array.volume_max_base_m = {1, 2, 3};
  const auto back = ParseArray(WriteArray(array), "back");
  ASSERT_TRUE(back.ok()) << back.error();
  const base::Calibration& same = back->calibration;
  EXPECT_EQ(same.moment_Am2, array.moment_Am2);
  EXPECT_EQ(same.core_kappa, array.core_kappa);
  EXPECT_EQ(same.sensor_noise_T, array.sensor_noise_T);
  EXPECT_EQ(same.volume_max_base_m, array.volume_max_base_m);
  for (std::size_t i = 0; i < array.sensors.size(); ++i) {
    EXPECT_EQ(same.sensors[i].position_base_m, array.sensors[i].position_base_m);
    EXPECT_EQ(same.sensors[i].gain_sensor_base, array.sensors[i].gain_sensor_base);
    EXPECT_EQ(same.sensors[i].current_map_T_A, array.sensors[i].current_map_T_A);
    EXPECT_EQ(same.sensors[i].background_sensor_T, array.sensors[i].background_sensor_T);
  }
}

}  // namespace test_config_array
}  // namespace omni::config
