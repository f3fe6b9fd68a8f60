// docs/scenes.md and the schema match the tables of a tag's numbers.
#include "scenes/keys/keys_page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

namespace omni::scenes {
namespace {

const std::string kRoot = OMNI_SOURCE_DIR;

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string Page() { return TextOf(kRoot + "/docs/scenes.md"); }
std::string Schema() { return TextOf(kRoot + "/scenes/schema/OMNI_haptic_material.schema.json"); }

TEST(KeysPage, DocumentsAreUpToDate) {
  ASSERT_FALSE(Page().empty() || Schema().empty());
  EXPECT_TRUE(UpdatedPage(Page()) == Page()) << "run build/release/bin/scene_keys_page " << kRoot;
  EXPECT_TRUE(UpdatedSchema(Schema()) == Schema()) << "run build/release/bin/scene_keys_page " << kRoot;
}

std::string Without(std::string text, const std::string& from, const std::string& to) {
  const std::size_t begin = text.find(from);
  text.erase(begin, text.find(to, begin) + to.size() - begin);
  return text;
}

TEST(KeysPage, PageGetsMissingRowsAndLosesRowsWithoutAKey) {
  const std::string row = "| `viscosity` |";
  ASSERT_NE(Page().find(row), std::string::npos);
  EXPECT_TRUE(UpdatedPage(Without(Page(), row, "\n")) == Page());
  std::string more = Page();
  more.insert(more.find(row), "| `wobble` | m | 0 .. 1 | 0 | |\n");
  EXPECT_TRUE(UpdatedPage(more) == Page());
}

TEST(KeysPage, SchemaGetsMissingNumbersAndLosesThoseWithoutAKey) {
  using Json = nlohmann::ordered_json;
  Json less = Json::parse(Schema()), wrong = less;
  less["properties"]["magnet"]["properties"].erase("range");
  const std::string updated = UpdatedSchema(less.dump());
  EXPECT_TRUE(updated == Schema());
  wrong["properties"]["stiffness"]["maximum"] = 1;
  wrong["properties"]["wobble"] = {{"type", "number"}, {"maximum", 1}, {"default", 0}};
  EXPECT_TRUE(UpdatedSchema(wrong.dump()) == Schema());
}

TEST(KeysPage, RejectsAPageWithoutTheTable) { EXPECT_THROW(UpdatedPage("# Scenes\n"), std::runtime_error); }

}  // namespace
}  // namespace omni::scenes
