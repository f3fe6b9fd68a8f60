// TOML that nests deeper than toml++ can go is rejected before toml++ reads it.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "service/config/files/alignment_file.h"
#include "service/config/files/app_file.h"
#include "service/config/files/array_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/config/inputs/input_settings.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"
#include "tests/support/rig/example_calibration.h"

namespace omni::config {
namespace test_config_toml_limits {

std::string Repeated(const std::string& part, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += part;
  return text;
}

// Each 80 kB and deeper than a stack of 8 MB.
std::vector<std::string> DeepTexts() {
  constexpr std::size_t kDeep = 40'000;
  return {"a" + Repeated(".a", kDeep) + " = 1\n",
          "[a" + Repeated(".a", kDeep) + "]\n",
          "[[a" + Repeated(".a", kDeep) + "]]\n",
          "x = {a" + Repeated(".a", kDeep) + " = 1}\n",
          "\"\"" + Repeated(".''", kDeep) + " = 1\n",
          "a" + Repeated(" . a", kDeep) + " = 1\n",
          "x = " + Repeated("[", kDeep) + Repeated("]", kDeep) + "\n",
          "x = " + Repeated("{a=", kDeep) + "1" + Repeated("}", kDeep) + "\n",
          "x = " + Repeated("[{a=", kDeep) + "1" + Repeated("}]", kDeep) + "\n"};
}

TEST(TomlLimits, EveryReaderRejectsDeeplyNestedFiles) {
  for (const std::string& text : DeepTexts()) {
    const std::string start = text.substr(0, 20);
    EXPECT_FALSE(ParseDevice(text, "f").ok()) << start;
    EXPECT_FALSE(ParseTwin(text, "f").ok()) << start;
    EXPECT_FALSE(ParseCalibration(text, "f", support::NominalBase()).ok()) << start;
    EXPECT_FALSE(ParseMarks(text, "f").ok()) << start;
    EXPECT_FALSE(ParseArray(text, "f").ok()) << start;
    EXPECT_FALSE(ParseAlignments(text, "f").ok()) << start;
    EXPECT_FALSE(ParseInputSettings(text, "f").ok()) << start;
    EXPECT_FALSE(ParseAppFile(text, "f", "/scenes").ok()) << start;
    const auto parsed = ParseToml(text, "f.toml");
    ASSERT_FALSE(parsed.ok()) << start;
    EXPECT_EQ(parsed.error().rfind("f.toml:1: has ", 0), 0U) << parsed.error();
    EXPECT_NE(parsed.error().find("which no settings file needs"), std::string::npos) << parsed.error();
  }
}

std::string Refusal(const std::string& text, const TomlLimits& limits) {
  const base::Status checked = CheckToml(text, "f", limits);
  return checked.ok() ? "" : checked.error();
}

TEST(TomlLimits, ErrorsNameTheLimitAndTheLine) {
  EXPECT_NE(Refusal("a = 1\nb = 2\n", {.bytes = 11}).find("f: is longer than 11 bytes"), std::string::npos);
  EXPECT_NE(Refusal("a = 1\nb.c.d = 2\n", {.parts = 2}).find("f:2: has a key of more than 2 parts"), std::string::npos);
  EXPECT_NE(Refusal("a = 1\n\nb = [[], [[]]]\n", {.depth = 2}).find("f:3: has arrays or tables nested deeper than 2"),
            std::string::npos);
  EXPECT_NE(Refusal("a = [1, 2, 3]\n", {.values = 3}).find("f:1: has more than 3 values"), std::string::npos);
  EXPECT_NE(Refusal("abcd = 1\n", {.word = 3}).find("f:1: has a word of more than 3 bytes"), std::string::npos);
}

TEST(TomlLimits, IgnoresStringsAndComments) {
  const TomlLimits narrow{.values = 4, .parts = 2, .depth = 1, .word = 8};
  EXPECT_EQ(Refusal("# [[[[ a.b.c.d.e.f = 1,2,3,4,5,6\na = \"[[[[ a.b.c.d.e , = \\\" [[[\"\n", narrow), "");
  EXPECT_EQ(Refusal("a = '[[[[ a.b.c.d.e , = \\'\n# it's\nb = 1.5\n", narrow), "");
  EXPECT_EQ(Refusal("a = \"\"\"\n[[[ \"\" a.b.c.d\n\\\"\"\" ,,,,,,,, \"\"\"\"\"\nb = 2\n", narrow), "");
  EXPECT_EQ(Refusal("a = '''[[[ ''\n''' # a.b.c.d.e\nb = \"\"\nc = ''\n", narrow), "");
  EXPECT_NE(Refusal("a = \"\"\"\"\"\"\nb = [[]]\n", narrow), "") << "an empty text, then arrays";
  EXPECT_NE(Refusal("a = \"x\" b = [[]]\n", narrow), "");
}

// Levels of a node, as toml++ made it.
std::size_t Levels(const toml::node& node) {
  std::size_t deepest = 0;
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) deepest = std::max(deepest, Levels(value));
  } else if (const toml::array* array = node.as_array()) {
    for (const toml::node& element : *array) deepest = std::max(deepest, Levels(element));
  }
  return deepest + 1;
}

// Words that change between text, comment and structure: where the scanner and toml++ read one differently, a file
// could nest deeper than the scanner finds.
TEST(TomlLimits, AcceptedFilesNeverExceedTheDepth) {
  static const char* const kWords[] = {"a",    "b.c",    ".",         "\"", "\"\"\"", "'",      "'''", "\\",
                                       "\\\"", "#",      "\n",        "\n", "=",      " = ",    "[",   "]",
                                       "[[",   "]]",     "{",         "}",  ", ",     "1",      "1.5", "\"x\"",
                                       "'y'",  "\"k\".", "a.b.c.d.e", "\t", "\r\n",   "a = 1\n"};
  const char* many = std::getenv("OMNI_FUZZ");
  const std::size_t count = many != nullptr ? std::stoul(many) : 30'000;
  constexpr TomlLimits kNarrow{.parts = 3, .depth = 2};
  std::mt19937 random(9);
  const auto below = [&random](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  std::size_t read = 0, passed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::string text = below(2) == 0 ? "" : "a = ";
    for (std::size_t k = 1 + below(16); k > 0; --k) text += kWords[below(std::size(kWords))];
    const auto parsed = ParseToml(text, "f");  // within the usual limits
    if (!parsed.ok()) continue;
    ++read;
    if (!CheckToml(text, "f", kNarrow).ok()) continue;
    ++passed;
    // The root, a table's name, and at each of two levels within a value another key.
    ASSERT_LE(Levels(*parsed), 1 + 3 + 3 + 2 * 3 + 2) << text;
    const bool flat = CheckToml(text, "f", {.parts = 1, .depth = 1}).ok();
    if (flat) {
      ASSERT_LE(Levels(*parsed), 4U) << text;
    }
  }
  RecordProperty("texts", static_cast<int>(count));
  EXPECT_GT(read, count / 100);
  EXPECT_LT(passed, read);
}

}  // namespace test_config_toml_limits
}  // namespace omni::config
