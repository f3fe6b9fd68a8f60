// Any settings file is rejected with a message, or every number of the result is finite and in range.
// scripts/fuzz runs more of them than a test run has time for, by OMNI_FUZZ.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "service/config/files/app_file.h"
#include "service/config/files/device_file.h"
#include "tests/support/rig/example_calibration.h"

namespace omni::config {
namespace test_config_mutations {

std::string ReadFile(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  EXPECT_FALSE(text.str().empty()) << path;
  return text.str();
}

// Seeded small damage: bytes, numbers, lines, cuts, and words that TOML reads in its own way.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string Mutate(std::string text) {
    const int count = 1 + static_cast<int>(Below(3));
    for (int i = 0; i < count && !text.empty(); ++i) MutateOnce(text);
    return text;
  }

 private:
  std::size_t Below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  void MutateOnce(std::string& text) {
    static const char* const kWords[] = {"nan",  "-inf", "1e308", "-1", "0",     "1e-320", "9223372036854775807",
                                         "true", "[]",   "{}",    "''", "[[x]]", "0x7f",   "\"\xC3\x28\""};
    switch (Below(5)) {
      case 0:
        text[Below(text.size())] = static_cast<char>(Below(256));
        break;
      case 1:
        text.erase(Below(text.size()), 1 + Below(20));
        break;
      case 2:
        text.insert(Below(text.size()), text.substr(Below(text.size()), Below(60)));
        break;
      case 3:
        ReplaceValue(text, kWords[Below(std::size(kWords))]);
        break;
      default:
        if (Below(10) == 0) text.resize(Below(text.size()));
        text += "\n";
        break;
    }
  }

  void ReplaceValue(std::string& text, const std::string& word) {
    const std::size_t at = text.find_first_of("=[,", Below(text.size()));
    if (at == std::string::npos) return;
    const std::size_t end = text.find_first_of(",]\n#", at + 1);
    text.replace(at + 1, end == std::string::npos ? end : end - at - 1, word);
  }

  std::mt19937 random_;
};

bool IsWithin(double value, double low, double high) { return value >= low && value <= high; }
bool Unit(double square) { return std::abs(square - 1) < 1e-12; }

void ExpectSane(const base::DeviceGeometry& d) {
  EXPECT_TRUE(IsWithin(d.magnet.radius_m, 1e-3, 0.05) && IsWithin(d.magnet.half_height_m, 2e-4, 0.05));
  EXPECT_TRUE(IsWithin(d.magnet.remanence_T, 0.1, 1.6) && IsWithin(d.magnet.mass_kg, 1e-3, 1));
  EXPECT_TRUE(IsWithin(d.magnet.tip_offset_m, 0, 0.2));
  EXPECT_TRUE(IsWithin(d.core_radius_m, 1e-3, 0.1) && IsWithin(d.core_kappa, 0, 1));
  EXPECT_TRUE(d.hull_radius_m > d.core_radius_m && d.hull_radius_m <= 0.2);
  EXPECT_TRUE(IsWithin(d.sensor_range_T, 1e-5, 1) && d.sensor_lsb_T > 0 && d.sensor_lsb_T < d.sensor_range_T);
  for (const double noise_T : d.sensor_noise_T) EXPECT_TRUE(IsWithin(noise_T, 0, 1e-3));
  EXPECT_TRUE(IsWithin(d.current_max_A, 0.01, 100) && IsWithin(d.current_slew_A_s, 1, 1e7));
  EXPECT_TRUE(IsWithin(d.force_max_N, 0.01, 20) && IsWithin(d.supply_V, 1, 100));
  EXPECT_TRUE(IsWithin(d.temperature_derate_C, 0, 150) && d.temperature_max_C > d.temperature_derate_C);
  for (const base::SensorGeometry& sensor : d.sensors) {
    const base::Vec3& p = sensor.position_base_m;
    const base::Quat& q = sensor.orientation_base_sensor;
    EXPECT_TRUE(Norm(p) > d.core_radius_m && Norm(p) < 1);
    EXPECT_TRUE(Unit(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z));
  }
  for (const base::CoilGeometry& coil : d.coils) {
    const base::Vec3& a = coil.axis_base;
    EXPECT_TRUE(Unit(a.x * a.x + a.y * a.y + a.z * a.z));
    EXPECT_TRUE(coil.turns >= 1 && coil.turns <= 100000 && coil.layers >= 1 && coil.layers <= 1000);
    EXPECT_TRUE(coil.shell_radius_min_m >= d.core_radius_m && coil.shell_radius_max_m > coil.shell_radius_min_m);
    EXPECT_TRUE(coil.shell_radius_max_m <= d.hull_radius_m && coil.band_half_width_m > 0);
    EXPECT_TRUE(IsWithin(coil.resistance_20C_ohm, 1e-3, 1e3) && IsWithin(coil.inductance_H, 1e-7, 1));
  }
}

TEST(ConfigMutations, MutatedDeviceFilesAreRejectedOrInRange) {
  const std::string manifest = ReadFile(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  const char* asked = std::getenv("OMNI_FUZZ");
  const unsigned files = asked == nullptr ? 1500 : static_cast<unsigned>(std::strtoul(asked, nullptr, 10));
  unsigned accepted = 0, refused = 0;
  for (unsigned seed = 0; seed < files; ++seed) {
    const auto device = ParseDevice(Mutator(seed).Mutate(manifest), "seed " + std::to_string(seed));
    SCOPED_TRACE(seed);
    if (device.ok()) {
      ++accepted;
      ExpectSane(*device);
    } else {
      ++refused;
      EXPECT_EQ(device.error().rfind("seed " + std::to_string(seed), 0), 0u) << device.error();
      EXPECT_EQ(device.error().find_first_of("\n\033"), std::string::npos) << device.error();
    }
  }
  // Both must happen often, or this test covers one side only.
  RecordProperty("files", static_cast<int>(files));
  RecordProperty("refused", static_cast<int>(refused));
  EXPECT_GT(accepted, files / 10);
  EXPECT_GT(refused, files / 10);
}

TEST(ConfigMutations, MutatedAppFilesAreRejectedOrInRange) {
  const std::string file = "offset_base_m = [0.01, 0.0, 0.0]\nscale = 1.5\nforce_scale = 0.5\n" +
                           ReadFile(OMNI_SOURCE_DIR "/manifests/apps.d/10-extrusion.toml") +
                           "secondary = [\"double_tap\", \"key:KEY_B\"]\npress_N = 0.3\nrelease_N = 0.1\ndwell_s = 2\n";
  int accepted = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 1500; ++seed) {
    const auto entry = ParseAppFile(Mutator(seed).Mutate(file), "seed", "/scenes");
    SCOPED_TRACE(seed);
    entry.ok() ? ++accepted : ++refused;
    if (!entry.ok()) continue;
    EXPECT_TRUE(!entry->application_glob.empty() && entry->application_glob.size() <= 127);
    EXPECT_TRUE(entry->scene.empty() ? entry->inputs.has_value() : entry->scene.front() == '/');
    if (entry->inputs) {
      const base::InputThresholds& t = entry->inputs->mapping.thresholds;
      EXPECT_TRUE(IsWithin(t.press_N, 0.02, 5) && IsWithin(t.release_N, 0.01, 5) && t.release_N < t.press_N);
      EXPECT_TRUE(IsWithin(t.dwell_s, 0.1, 10));
      EXPECT_LE(entry->inputs->keys.size(), static_cast<std::size_t>(base::kMaxKeys));
    }
    EXPECT_TRUE(IsWithin(entry->scale, 1e-4, 1e4) && IsWithin(entry->force_scale, 0, 1));
    EXPECT_TRUE(IsWithin(entry->offset_base_m.x, -0.2, 0.2) && IsWithin(entry->offset_base_m.y, -0.2, 0.2));
    EXPECT_TRUE(IsWithin(entry->offset_base_m.z, -0.2, 0.2));
  }
  EXPECT_GT(accepted, 150);
  EXPECT_GT(refused, 150);
}

// A damaged calibration would push the pen the wrong way: it is rejected, or equal to the original.
TEST(ConfigMutations, MutatedCalibrationFilesAreRejectedOrUnchanged) {
  const config::ExpectedBase of = support::NominalBase();
  const std::string file = WriteCalibration(support::ExampleCalibration(), of.device);
  int same = 0;
  int refused = 0;
  const auto check = [&](const std::string& text) {
    const auto read = ParseCalibration(text, "seed", of);
    read.ok() ? ++same : ++refused;
    if (read.ok()) {
      EXPECT_EQ(WriteCalibration(*read, of.device), file);
    }
  };
  std::mt19937 random(5);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  for (unsigned seed = 0; seed < 1500; ++seed) {
    SCOPED_TRACE(seed);
    check(Mutator(seed).Mutate(file));
    std::string flipped = file;
    for (std::size_t n = 1 + below(4); n > 0; --n) flipped[below(file.size())] ^= static_cast<char>(1 + below(255));
    check(flipped);
    std::string bit = file;
    bit[below(file.size())] ^= static_cast<char>(1 << below(8));
    check(bit);
  }
  EXPECT_GT(same, 50);
  EXPECT_GT(refused, 3000);
  std::printf("[ figure   ] 4500 damaged calibrations: %d refused, %d that say what the original says\n", refused,
              same);
}

}  // namespace test_config_mutations
}  // namespace omni::config
