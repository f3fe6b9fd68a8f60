// The twin's file: what is read, that every key counts, and what each mistake is told.
#include <gtest/gtest.h>

#include <string>

#include "service/config/twin_file.h"
#include "tests/support/manifest_text.h"

namespace omni::config {
namespace test_config_twin {

std::string Manifest() { return test::ManifestText("device/twin.toml"); }

// The manifest with the first occurrence of `from` replaced.
std::string Changed(const std::string& from, const std::string& to) { return test::Replaced(Manifest(), from, to); }

TEST(ConfigTwin, ReadsTheManifest) {
  const auto twin = LoadTwinFile(OMNI_SOURCE_DIR "/manifests/device/twin.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  EXPECT_DOUBLE_EQ(twin->imperfections.sensor_position_m, 5e-5);
  EXPECT_DOUBLE_EQ(twin->thermal.copper_J_K, 44.4);
  EXPECT_DOUBLE_EQ(twin->effects.remanence_Am2, 4e-3);
  EXPECT_DOUBLE_EQ(twin->effects.core_conductivity_S_m, 1e7);
  EXPECT_DOUBLE_EQ(twin->effects.earth_field_base_T.z, -4.4e-5);
  EXPECT_TRUE(twin->effects.background_known);
  EXPECT_DOUBLE_EQ(twin->sensor.noise_uhp_T[2], 4.1e-7);
  EXPECT_DOUBLE_EQ(DefaultTwin().effects.pwm_frequency_Hz, twin->effects.pwm_frequency_Hz);
}

TEST(ConfigTwin, RawBackgroundIsAChoice) {
  const auto twin = ParseTwin(Changed("background = \"known\"", "background = \"raw\""), "test.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  EXPECT_FALSE(twin->effects.background_known);
  EXPECT_FALSE(ParseTwin(Changed("background = \"known\"", "background = \"some\""), "test.toml").ok());
}

TEST(ConfigTwin, MistakesNameFileKeyValueAndRange) {
  const auto wrong = ParseTwin(Changed("remanence_Am2 = 4.0e-3", "remanence_Am2 = 4.0"), "test.toml");
  ASSERT_FALSE(wrong.ok());
  for (const char* word : {"test.toml:", "core.remanence_Am2", "= 4", "[0, 1]"}) {
    EXPECT_NE(wrong.error().find(word), std::string::npos) << word << " not in: " << wrong.error();
  }
  EXPECT_FALSE(ParseTwin(Changed("copper_J_K = 44.4", ""), "test.toml").ok());
  EXPECT_FALSE(ParseTwin(Changed("pwm_residual", "pwm_residuel"), "test.toml").ok());
  EXPECT_FALSE(ParseTwin(Changed("run_s = 600.0", "run_s = nan"), "test.toml").ok());
  EXPECT_FALSE(ParseTwin("", "test.toml").ok());
}

}  // namespace test_config_twin
}  // namespace omni::config
