// Any array file is rejected with a message, or every number of the result is finite and in range.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/config/files/array_file.h"

namespace omni::config {
namespace test_config_array_mutations {

std::string GoodText() {
  base::Calibration array;
  array.device = "patch";
  array.magnet = {.radius_m = 0.005, .half_height_m = 0.004};
  array.moment_Am2 = 0.6;
  array.sensor_noise_T = {1e-6, 1e-6, 2e-6};
  array.sensor_range_T = 0.05;
  array.core_radius_m = 0.01;
  array.hull_radius_m = 0.02;
  array.volume_max_base_m = {0.1, 0.1, 0.1};
  for (int i = 0; i < 6; ++i) {
    base::SensorCalibration sensor;
    sensor.position_base_m = {0.03 + 0.01 * i, 0.02, -0.05};
    sensor.current_map_T_A[4] = 1e-5;
    array.sensors.push_back(sensor);
  }
  return WriteArray(array);
}

// Seeded small damage: words in place of values, bytes, cuts, repeated parts.
std::string Damaged(std::string text, unsigned seed) {
  static const char* const kWords[] = {
      "nan", "-inf", "1e308", "-1", "0", "1e-320", "true", "[]", "{}", "''", "9223372036854775807"};
  std::mt19937 random(seed);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  for (std::size_t i = 0, count = 1 + below(2); i < count; ++i) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, 1 + below(20));
        break;
      case 2:
        text.insert(at, text.substr(below(text.size()), below(80)));
        break;
      default: {
        const std::size_t value = text.find_first_of("=[,", at);
        if (value == std::string::npos) break;
        const std::size_t end = text.find_first_of(",]\n", value + 1);
        text.replace(value + 1, end == std::string::npos ? end : end - value - 1, kWords[below(std::size(kWords))]);
      }
    }
  }
  return text;
}

void ExpectSane(const base::Calibration& array) {
  EXPECT_TRUE(array.sensors.size() >= base::kArraySensorsMin && array.sensors.size() <= base::kArraySensorsMax);
  EXPECT_TRUE(array.moment_Am2 > 0 || array.magnet.remanence_T > 0);
  EXPECT_TRUE(array.moment_Am2 <= 1e4 && array.magnet.remanence_T <= 2);
  EXPECT_TRUE(array.magnet.radius_m >= 1e-4 && array.magnet.radius_m <= 0.2);
  EXPECT_TRUE(array.magnet.half_height_m >= 1e-4 && array.magnet.half_height_m <= 0.2);
  for (const double noise_T : array.sensor_noise_T) EXPECT_TRUE(noise_T > 0 && noise_T <= 1e-2);
  EXPECT_TRUE(array.core_kappa >= 0 && array.core_kappa <= 1 && array.core_radius_m >= 0);
  for (const base::SensorCalibration& sensor : array.sensors) {
    const base::Vec3& p = sensor.position_base_m;
    EXPECT_TRUE(Norm(p) <= 18);
    for (const double entry : sensor.gain_sensor_base) EXPECT_LE(std::abs(entry), 400);
    for (const double entry : sensor.current_map_T_A) EXPECT_LE(std::abs(entry), 1);
    EXPECT_LE(std::abs(sensor.background_sensor_T.x), 0.1);
  }
}

TEST(ConfigArrayMutations, MutatedFilesAreRejectedOrInRange) {
  const std::string good = GoodText();
  ASSERT_TRUE(ParseArray(good, "good").ok()) << ParseArray(good, "good").error();
  int accepted = 0, refused = 0;
  for (unsigned seed = 0; seed < 800; ++seed) {
    SCOPED_TRACE(seed);
    const auto array = ParseArray(Damaged(good, seed), "seed");
    if (array.ok()) {
      ++accepted;
      ExpectSane(array->calibration);
    } else {
      ++refused;
      EXPECT_EQ(array.error().rfind("seed", 0), 0U) << array.error();
      EXPECT_EQ(array.error().find_first_of("\n\033"), std::string::npos) << array.error();
    }
  }
  EXPECT_GT(accepted, 15);  // most of the text is numbers and keys: little of it can change unnoticed
  EXPECT_GT(refused, 80);
}

}  // namespace test_config_array_mutations
}  // namespace omni::config
