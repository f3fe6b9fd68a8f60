// The twin's file: what is read, that every key counts, and what each mistake is told.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "service/config/twin_file.h"

namespace omni::config {
namespace {

std::string Manifest() {
  std::ifstream file(OMNI_SOURCE_DIR "/manifests/device/twin.toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string Changed(const std::string& from, const std::string& to) {
  std::string text = Manifest();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ConfigTwin, ReadsTheManifest) {
  const auto twin = LoadTwinFile(OMNI_SOURCE_DIR "/manifests/device/twin.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  EXPECT_DOUBLE_EQ(twin->imperfections.sensor_position_m, 5e-5);
  EXPECT_DOUBLE_EQ(twin->thermal.copper_J_K, 44.4);
  EXPECT_DOUBLE_EQ(twin->effects.remanence_Am2, 4e-3);
  EXPECT_DOUBLE_EQ(twin->effects.core_conductivity_S_m, 1e7);
  EXPECT_DOUBLE_EQ(twin->effects.earth_field_base_T.z, -4.4e-5);
  EXPECT_TRUE(twin->effects.background_known);
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

}  // namespace
}  // namespace omni::config
