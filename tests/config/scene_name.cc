// Scenes are found by name.
#include <gtest/gtest.h>

#include <filesystem>

#include "service/config/paths.h"
#include "tests/support/process/temp_folder.h"

namespace omni::config {
namespace test_config_scene_name {

class SceneNames : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* file : {"scenes/dragon.glb", "scenes/block.gltf", "mine/cup.glb", "mine/dragon.glb"}) {
      folder_.Write(file, "glTF");
    }
    std::filesystem::current_path(folder_.Path("mine"));
  }
  void TearDown() override { std::filesystem::current_path("/"); }

  std::string scenes() const { return folder_.Path("scenes"); }
  std::string Found(const std::string& name) const {
    const base::Result<std::string> found = FindScene(name, scenes());
    return found.ok() ? *found : "none: " + found.error();
  }

  const test::TempFolder folder_;
};

TEST_F(SceneNames, AreFoundWithAndWithoutExtension) {
  EXPECT_EQ(Found("block"), folder_.Path("scenes/block.gltf"));
  EXPECT_EQ(Found("block.gltf"), folder_.Path("scenes/block.gltf"));
  EXPECT_EQ(Found("cup"), "cup.glb");
  EXPECT_EQ(Found("./cup"), "./cup.glb");
  EXPECT_EQ(Found("../scenes/dragon"), "../scenes/dragon.glb");
  EXPECT_EQ(Found(folder_.Path("mine/cup")), folder_.Path("mine/cup.glb"));
  EXPECT_EQ(Found(folder_.Path("mine/cup.glb")), folder_.Path("mine/cup.glb"));
}

TEST_F(SceneNames, LocalFilePrecedesShippedOne) {
  EXPECT_EQ(Found("dragon"), "dragon.glb");
  std::filesystem::remove(folder_.Path("mine/dragon.glb"));
  EXPECT_EQ(Found("dragon"), folder_.Path("scenes/dragon.glb"));
  EXPECT_EQ(Found("dragon.glb"), folder_.Path("scenes/dragon.glb"));
}

TEST_F(SceneNames, ErrorNamesSearchedFoldersAndNearestScene) {
  const struct {
    std::string name;
    std::vector<std::string> parts;
  } rows[] = {
      {"dargon", {"'dargon'", "this folder", scenes(), "did you mean 'dragon'?"}},
      {"dargon.glb", {"did you mean 'dragon.glb'?"}},
      {"blcok", {"did you mean 'block'?"}},
      {folder_.Path("mine/cpu"), {folder_.Path("mine"), "did you mean '" + folder_.Path("mine/cup") + "'?"}},
      {"../mine/cpu.glb", {"looked in ../mine", "did you mean '../mine/cup.glb'?"}},
      {"spaceship", {"'spaceship'", scenes()}},
      {"", {"''"}},
      {"no/such/folder/dragon", {"no/such/folder"}},
  };
  for (const auto& row : rows) {
    const std::string said = Found(row.name);
    EXPECT_EQ(said.find("none: there is no scene"), 0U) << said;
    for (const std::string& part : row.parts)
      EXPECT_NE(said.find(part), std::string::npos) << part << " not in " << said;
  }
  EXPECT_EQ(Found("spaceship").find("did you mean"), std::string::npos);
  EXPECT_EQ(Found(folder_.Path("mine")).find("none: "), 0U) << "a folder is no scene";
}

}  // namespace test_config_scene_name
}  // namespace omni::config
