// The [inputs] table of applications' files, inputs.toml, and the keys that all of them share.
#include <gtest/gtest.h>

#include "service/config/inputs/input_settings.h"
#include "service/config/inputs/input_table.h"
#include "service/config/paths.h"
#include "tests/support/process/temp_folder.h"

namespace omni::config {
namespace test_config_inputs {

using base::InputComponent;
using base::InputSource;

std::string App(const std::string& inputs) { return "application = \"a\"\nscene = \"b.glb\"\n[inputs]\n" + inputs; }

std::string InputErrorOf(const std::string& inputs) {
  const auto entry = ParseAppFile(App(inputs), "test.toml", "/scenes");
  EXPECT_FALSE(entry.ok()) << inputs;
  return entry.ok() ? std::string() : entry.error();
}

std::string SettingsErrorOf(const std::string& text) {
  const auto settings = ParseInputSettings(text, "inputs.toml");
  EXPECT_FALSE(settings.ok()) << text;
  return settings.ok() ? std::string() : settings.error();
}

void ExpectWords(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

TEST(InputSettings, HandIsReadAndChecked) {
  EXPECT_EQ(ParseInputSettings("", "inputs.toml")->hand, "auto");
  EXPECT_EQ(ParseInputSettings("hand = \"left\"\n", "inputs.toml")->hand, "left");
  const auto wrong = ParseInputSettings("hand = \"both\"\n", "inputs.toml");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().find("inputs.toml:1"), std::string::npos) << wrong.error();
}

TEST(ConfigInputs, OmittedKeysKeepTheirDefaults) {
  const auto entry = ParseAppFile(App("secondary = [\"double_tap\", \"key:KEY_B\"]\npress_N = 0.3\n"), "f", "/s");
  ASSERT_TRUE(entry.ok()) << entry.error();
  ASSERT_TRUE(entry->inputs);
  const base::InputMapping& mapping = entry->inputs->mapping;
  EXPECT_EQ(mapping.at(InputComponent::kSecondary).plus, SourceBit(InputSource::kDoubleTap) | base::KeyBit(0));
  EXPECT_EQ(entry->inputs->keys, std::vector<std::uint16_t>{48});
  EXPECT_EQ(mapping.at(InputComponent::kMenu).plus, SourceBit(InputSource::kFlick));
  EXPECT_EQ(mapping.thresholds.press_N, 0.3);
  EXPECT_EQ(mapping.thresholds.dwell_s, base::InputThresholds{}.dwell_s);
  EXPECT_FALSE(ParseAppFile("application = \"a\"\nscene = \"b\"\n", "f", "/s")->inputs);
}

TEST(ConfigInputs, EverySourceAndComponentHasAName) {
  for (int i = 0; i < base::kInputComponentCount; ++i) {
    const std::string component = ComponentText(static_cast<InputComponent>(i));
    for (int s = 0; s <= static_cast<int>(InputSource::kThumbstickY); ++s) {
      const auto source = static_cast<InputSource>(s);
      const auto entry = ParseAppFile(App(component + " = [\"" + SourceText(source, {}) + "\"]\n"), "f", "/s");
      ASSERT_TRUE(entry.ok()) << entry.error();
      EXPECT_EQ(entry->inputs->mapping.at(static_cast<InputComponent>(i)).plus, SourceBit(source));
    }
    EXPECT_EQ(
        ParseAppFile(App(component + " = []\n"), "f", "/s")->inputs->mapping.at(static_cast<InputComponent>(i)).plus,
        0u)
        << "an empty list takes the default away";
  }
}

TEST(ConfigInputs, AcceptsFilesWithInputsOnly) {
  const auto entry = ParseAppFile("application = \"a\"\n[inputs]\n", "f", "/s");
  ASSERT_TRUE(entry.ok()) << entry.error();
  EXPECT_TRUE(entry->scene.empty());
  EXPECT_TRUE(entry->inputs);
}

TEST(ConfigInputs, AxesHaveTwoSigns) {
  const auto entry = ParseAppFile(App("thumbstick_x = [\"key:KEY_RIGHT\", \"-key:KEY_LEFT\"]\n"), "f", "/s");
  ASSERT_TRUE(entry.ok()) << entry.error();
  EXPECT_EQ(entry->inputs->mapping.at(InputComponent::kThumbstickX).plus, base::KeyBit(0));
  EXPECT_EQ(entry->inputs->mapping.at(InputComponent::kThumbstickX).minus, base::KeyBit(1));
  ExpectWords(InputErrorOf("select = [\"-press\"]\n"), {"inputs.select", "-press", "is not a source"});
}

TEST(ConfigInputs, ErrorsNameKeyValueAndLimit) {
  ExpectWords(InputErrorOf("secondary = [\"doubletap\"]\n"),
              {"test.toml:4", "inputs.secondary", "doubletap", "double_tap", "key:KEY_B"});
  ExpectWords(InputErrorOf("menu = [\"key:KEY_BANANA\"]\n"), {"test.toml:4", "KEY_BANANA", "input-event-codes.h"});
  ExpectWords(InputErrorOf("menu = [\"key:0\"]\n"), {"key:0", "1 to 767"});
  ExpectWords(InputErrorOf("menu = [\"key:768\"]\n"), {"key:768"});
  ExpectWords(InputErrorOf("menu = [\"key:\"]\n"), {"is not a key"});
  ExpectWords(InputErrorOf("menu = [\"\"]\n"), {"inputs.menu[0]", "1 to 64 bytes"});
  ExpectWords(InputErrorOf("menu = [1]\n"), {"inputs.menu[0]", "integer"});
  ExpectWords(InputErrorOf("menu = \"flick\"\n"), {"inputs.menu", "string", "array"});
  ExpectWords(InputErrorOf("button = [\"tap\"]\n"), {"inputs.button", "unknown", "secondary"});
  ExpectWords(InputErrorOf("dwell_s = 0.01\n"), {"inputs.dwell_s", "0.01", "[0.1, 10]"});
  ExpectWords(InputErrorOf("dwell_s = nan\n"), {"inputs.dwell_s", "nan"});
  ExpectWords(InputErrorOf("press_N = 0.05\n"), {"inputs.release_N", "not below press_N"});
  ExpectWords(InputErrorOf("detent_release_N = 0.9\n"), {"detent_release_N", "not below detent_press_N"});
  std::string many = "menu = [";
  for (int i = 1; i <= 17; ++i) many += "\"key:" + std::to_string(i) + "\",";
  ExpectWords(InputErrorOf(many + "]\n"), {"inputs.menu", "17", "at most 16"});
}

TEST(ConfigInputs, RejectsMoreKeysThanSlots) {
  std::string text;
  int key = 1;
  for (const char* component : {"select", "secondary", "menu"}) {
    text += std::string(component) + " = [";
    for (int i = 0; i < 11; ++i) text += "\"key:" + std::to_string(key++) + "\",";
    text += "]\n";
  }
  ExpectWords(InputErrorOf(text), {"inputs.menu", "limit is 32"});
}

TEST(ConfigInputs, ApplicationsShareKeySlots) {
  const test::TempFolder folder;
  folder.Write("apps/1.toml", App("menu = [\"key:KEY_B\", \"key:KEY_C\"]\n"));
  folder.Write("apps/2.toml", App("select = [\"key:KEY_C\", \"press\"]\nmenu = [\"key:KEY_D\"]\n"));
  folder.Write("inputs.toml",
               "[inputs]\nsecondary = [\"key:KEY_D\"]\n[[devices]]\nname = \"*Foot*\"\n"
               "[[devices]]\npath = \"/dev/input/by-id/x\"\ngrab = true\n");
  AppTable apps = LoadAppTable({folder.Path("apps")}, "/s");
  ASSERT_EQ(apps.entries.size(), 2u);
  const InputPlan plan = PlanInputs(folder.Path("inputs.toml"), apps);
  EXPECT_TRUE(apps.problems.empty());
  EXPECT_EQ(plan.slots, (std::vector<std::uint16_t>{*KeyCode("KEY_D"), *KeyCode("KEY_B"), *KeyCode("KEY_C")}));
  EXPECT_EQ(plan.fallback.mapping.at(InputComponent::kSecondary).plus, base::KeyBit(0));
  EXPECT_EQ(apps.entries[0].inputs->mapping.at(InputComponent::kMenu).plus, base::KeyBit(1) | base::KeyBit(2));
  EXPECT_EQ(apps.entries[1].inputs->mapping.at(InputComponent::kSelect).plus,
            base::KeyBit(2) | SourceBit(InputSource::kPress));
  EXPECT_EQ(apps.entries[1].inputs->mapping.at(InputComponent::kMenu).plus, base::KeyBit(0));
  ASSERT_EQ(plan.devices.size(), 2u);
  EXPECT_EQ(plan.devices[0].name_glob, "*Foot*");
  EXPECT_FALSE(plan.devices[0].grab);
  EXPECT_TRUE(plan.devices[1].grab);
  EXPECT_EQ(SourceText(InputSource::kFirstKey, plan.slots), "key:KEY_D");
}

TEST(ConfigInputs, ApplicationWhoseKeysDoNotFitUsesTheFallback) {
  AppTable apps;
  for (int app = 0; app < 3; ++app) {
    std::string text = "menu = [";
    for (int i = 0; i < 16; ++i) text += "\"key:" + std::to_string(1 + 16 * app + i) + "\",";
    apps.entries.push_back(*ParseAppFile(App(text + "]\n"), "app" + std::to_string(app), "/s"));
  }
  const InputPlan plan = PlanInputs("", apps);
  EXPECT_TRUE(apps.entries[0].inputs && apps.entries[1].inputs);
  EXPECT_FALSE(apps.entries[2].inputs);
  ASSERT_EQ(apps.problems.size(), 1u);
  ExpectWords(apps.problems[0], {"app2", "32", "not used"});
  EXPECT_EQ(plan.slots.size(), 32u);
}

TEST(ConfigInputs, ReadsNoDevicesWithoutAValidUserFile) {
  AppTable apps;
  const InputPlan plan = PlanInputs("/no/such/inputs.toml", apps);
  EXPECT_TRUE(apps.problems.empty());
  EXPECT_TRUE(plan.devices.empty());
  EXPECT_TRUE(plan.slots.empty());
  const test::TempFolder folder;
  folder.Write("inputs.toml", "[[devices]]\nname = 1\n");
  EXPECT_TRUE(PlanInputs(folder.Path("inputs.toml"), apps).devices.empty());
  ASSERT_EQ(apps.problems.size(), 1u);
  ExpectWords(apps.problems[0], {"inputs.toml:2", "devices[0].name"});
}

TEST(ConfigInputs, DevicesNeedEitherPathOrName) {
  ExpectWords(SettingsErrorOf("[[devices]]\ngrab = true\n"), {"inputs.toml", "exactly one"});
  ExpectWords(SettingsErrorOf("[[devices]]\nname = \"a\"\npath = \"/dev/b\"\n"), {"exactly one"});
  ExpectWords(SettingsErrorOf("[[devices]]\npath = \"event3\"\n"), {"devices[0].path", "event3", "absolute"});
  ExpectWords(SettingsErrorOf("[[devices]]\nname = \"a\"\ngrab = 1\n"), {"devices[0].grab", "true or false"});
  ExpectWords(SettingsErrorOf("[[devices]]\nname = \"a\"\ngarb = true\n"), {"garb", "unknown", "grab"});
  ExpectWords(SettingsErrorOf("[devices]\nname = \"a\"\n"), {"devices", "[[devices]]"});
  ExpectWords(SettingsErrorOf("device = 1\n"), {"device", "unknown", "devices"});
}

TEST(ConfigInputs, ParsesKeysByNameAndNumber) {
  EXPECT_EQ(KeyCode("KEY_A"), 30);
  EXPECT_EQ(KeyCode("BTN_LEFT"), 0x110);
  EXPECT_EQ(KeyCode("183"), 183);
  EXPECT_EQ(KeyNameOf(183), "KEY_F13");
  EXPECT_EQ(KeyNameOf(700), "700");
  for (const char* wrong : {"", "KEY_", "key_a", "-1", "0", "768", "1 ", " 1", "99999999999", "0x1e"}) {
    EXPECT_FALSE(KeyCode(wrong)) << wrong;
  }
}

}  // namespace test_config_inputs
}  // namespace omni::config
