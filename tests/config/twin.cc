// The twin's file: what is read, that every key counts, and the error of each mistake.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "service/config/files/twin_file.h"
#include "tests/support/process/manifest_text.h"
#include "tests/support/process/temp_folder.h"

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
  EXPECT_DOUBLE_EQ(IdealTwin().effects.pwm_frequency_Hz, twin->effects.pwm_frequency_Hz);
}

TEST(ConfigTwin, AcceptsRawBackground) {
  const auto twin = ParseTwin(Changed("background = \"known\"", "background = \"raw\""), "test.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  EXPECT_FALSE(twin->effects.background_known);
  EXPECT_FALSE(ParseTwin(Changed("background = \"known\"", "background = \"some\""), "test.toml").ok());
}

TEST(ConfigTwin, ErrorsNameFileKeyValueAndRange) {
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

TEST(ConfigTwin, FindsIdealAndRoomByName) {
  EXPECT_EQ(FindTwin("ideal")->effects.background_known, IdealTwin().effects.background_known);
  const auto room = FindTwin("room");
  ASSERT_TRUE(room.ok()) << room.error();
  EXPECT_FALSE(room->effects.background_known);
  EXPECT_NEAR(std::hypot(room->effects.earth_field_base_T.x, room->effects.earth_field_base_T.z), 5e-5, 1e-7);
  EXPECT_EQ(room->effects.room.steel.size(), 4U);
  EXPECT_DOUBLE_EQ(room->imperfections.sensor_position_m, 1e-3);
  EXPECT_DOUBLE_EQ(room->imperfections.coil_strength, IdealTwin().imperfections.coil_strength) << "omitted: as ideal";
  EXPECT_DOUBLE_EQ(room->thermal.copper_J_K, IdealTwin().thermal.copper_J_K);
  const auto file = LoadTwinFile(OMNI_SOURCE_DIR "/manifests/device/room.toml");
  ASSERT_TRUE(file.ok()) << file.error();
  EXPECT_DOUBLE_EQ(file->effects.room.mains_T, room->effects.room.mains_T);
  EXPECT_NE(FindTwin("/nowhere/x.toml").error().find("/nowhere/x.toml"), std::string::npos);
}

// Without a choice the twin stands in the room.
TEST(ConfigTwin, TheDefaultIsTheRoom) {
  EXPECT_FALSE(DefaultTwin().effects.background_known);
  EXPECT_FALSE(FindTwin("")->effects.background_known);
  EXPECT_EQ(FindTwin("")->effects.room.steel.size(), RoomTwin().effects.room.steel.size());
}

TEST(ConfigTwin, TextOfTwinChangesWithTheFileAndItsBase) {
  const test::TempFolder folder;
  const std::string path = folder.Write("mine.toml", "based_on = \"room\"\n[pen]\nmagnet_warming_K = 7\n");
  const std::string mine = *TextOfTwin(path);
  EXPECT_EQ(*TextOfTwin(""), *TextOfTwin("room"));
  EXPECT_NE(*TextOfTwin("ideal"), *TextOfTwin("room"));
  EXPECT_NE(mine, *TextOfTwin("room"));
  EXPECT_NE(mine.find(*TextOfTwin("room")), std::string::npos) << "what it is based on counts too";
  folder.Write("mine.toml", "based_on = \"room\"\n[pen]\nmagnet_warming_K = 8\n");
  EXPECT_NE(*TextOfTwin(path), mine);
  EXPECT_FALSE(TextOfTwin("/nowhere/x.toml").ok());
}

TEST(ConfigTwin, BasedOnFileOverridesOnlyItsOwnKeys) {
  const auto twin = ParseTwin("based_on = \"room\"\n[pen]\nmagnet_warming_K = 7", "test.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  EXPECT_DOUBLE_EQ(twin->effects.magnet_warming_K, 7);
  EXPECT_DOUBLE_EQ(twin->effects.magnet_per_K, IdealTwin().effects.magnet_per_K);
  EXPECT_EQ(twin->effects.room.steel.size(), 4U);
  const auto bare = ParseTwin("based_on = \"room\"\n[[steel]]\nposition_base_m = [0, 0, -0.15]", "test.toml");
  ASSERT_TRUE(bare.ok()) << bare.error();
  EXPECT_EQ(bare->effects.room.steel.size(), 1U) << "a list is replaced";
  EXPECT_NE(ParseTwin("based_on = \"desk\"", "test.toml").error().find("based_on"), std::string::npos);
  EXPECT_NE(ParseTwin("based_on = \"ideal\"\n[pen]\nwarming = 7", "test.toml").error().find("pen.warming"),
            std::string::npos);
}

constexpr const char* kRoom = R"(
[room]
turn_rate_rad_s = 0.17
turn_s = 9
mains_T = 1e-6
mains_third = 0.3
sensor_warming_K = 2
[[steel]]
shape = "plane"
position_base_m = [0, 0, -0.15]
strength = 0.8
[[steel]]
shape = "bar"
position_base_m = [0, 0.5, -0.4]
direction_base = [2e-1, 0, 0]
radius_m = 0.02
half_length_m = 0.6
from_s = 3
[[magnets]]
moment_Am2 = [0, 0, 0.1]
to_base_m = [0.13, 0, 0]
[[pens]]
moment_scale = 0.9
from_s = 4
[[field_steps]]
change_base_T = [2e-5, 0, 0]
at_s = 10
[[sensor_faults]]
kind = "swapped"
sensor = 2
other = 6
)";

TEST(ConfigTwin, ReadsARoom) {
  const auto twin = ParseTwin(Manifest() + kRoom, "test.toml");
  ASSERT_TRUE(twin.ok()) << twin.error();
  const base::RoomEffects& room = twin->effects.room;
  EXPECT_DOUBLE_EQ(room.turn_rate_rad_s, 0.17);
  EXPECT_DOUBLE_EQ(room.mains_Hz, 50);
  EXPECT_DOUBLE_EQ(twin->effects.sensor_warming_K, 2);
  ASSERT_EQ(room.steel.size(), 2U);
  EXPECT_EQ(room.steel[0].shape, base::SteelShape::kPlane);
  EXPECT_DOUBLE_EQ(room.steel[0].strength, 0.8);
  EXPECT_EQ(room.steel[1].shape, base::SteelShape::kBar);
  EXPECT_DOUBLE_EQ(room.steel[1].direction_base.x, 1) << "made a unit vector";
  EXPECT_DOUBLE_EQ(room.steel[1].from_s, 3);
  ASSERT_EQ(room.magnets.size(), 1U);
  EXPECT_EQ(room.magnets[0].from_base_m, room.magnets[0].to_base_m) << "at rest";
  ASSERT_EQ(room.pens.size(), 1U);
  EXPECT_DOUBLE_EQ(room.pens[0].moment_scale, 0.9);
  ASSERT_EQ(room.steps.size(), 1U);
  EXPECT_DOUBLE_EQ(room.steps[0].change_base_T.x, 2e-5);
  ASSERT_EQ(room.faults.size(), 1U);
  EXPECT_EQ(room.faults[0].kind, base::SensorFaultKind::kSwapped);
  EXPECT_EQ(room.faults[0].other, 6);
  EXPECT_TRUE(IdealTwin().effects.room.steel.empty());
}

TEST(ConfigTwin, RoomErrorsNameTheTable) {
  const struct {
    const char* from;
    const char* to;
    const char* named;
  } mistakes[] = {
      {"radius_m = 0.02\n", "", "steel[1].radius_m must be above 0"},
      {"half_length_m = 0.6", "half_length_m = 0.01", "steel[1].half_length_m"},
      {"[2e-1, 0, 0]", "[0, 0, 0]", "steel[1].direction_base has no direction"},
      {"\"plane\"", "\"cone\"", "steel[0].shape"},
      {"[0.13, 0, 0]", "[0.01, 0, 0]", "magnets[0].to_base_m lies inside the core"},
      {"to_base_m = [0.13, 0, 0]", "to_base_m = [0.13, 0, 0]\nleaves_s = 2\narrives_s = 1", "magnets[0].arrives_s"},
      {"other = 6", "other = 8", "sensor_faults[0].other"},
      {"other = 6", "", "sensor_faults[0].other"},
      {"at_s = 10", "", "field_steps[0].at_s"},
      {"mains_third", "mains_thrid", "room.mains_thrid"},
  };
  for (const auto& mistake : mistakes) {
    const auto twin = ParseTwin(Manifest() + test::Replaced(kRoom, mistake.from, mistake.to), "test.toml");
    ASSERT_FALSE(twin.ok()) << mistake.named;
    EXPECT_NE(twin.error().find(mistake.named), std::string::npos) << twin.error();
  }
  std::string many = Manifest();
  for (int i = 0; i < 17; ++i) many += "[[steel]]\nposition_base_m = [0, 0, -1]\n";
  EXPECT_NE(ParseTwin(many, "test.toml").error().find("steel"), std::string::npos);
}

}  // namespace test_config_twin
}  // namespace omni::config
