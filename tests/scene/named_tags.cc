// Tags that an application's file gives by name, for documents that lost theirs.
#include <gtest/gtest.h>

#include "service/scene/cache/cache_store.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_named_tags {

Loaded LoadTagged(const Model& model, const std::string& tags) {
  LoadOptions options;
  options.tags_by_name = tags;
  return LoadBytes(model.Bytes(), options);
}

// A node "tetra" and a material "plain" without any tag, and a second node.
Model Two() {
  Model model = Tetra();
  model.json["nodes"].push_back({{"name", "other"}, {"mesh", 1}, {"translation", {0.02, 0, 0}}});
  model.json["scenes"][0]["nodes"] = {0, 1};
  model.json["meshes"].push_back(model.json["meshes"][0]);
  model.json["meshes"][1]["primitives"][0].erase("material");
  return model;
}

TEST(SceneNamedTags, ANodeOrAMaterialIsTaggedByItsName) {
  for (const char* name : {"tetra", "plain"}) {
    Loaded loaded =
        LoadTagged(Two(), "{\"" + std::string(name) + R"(": {"stiffness": 321, "softness": {"model": "winkler"}}})");
    ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
    EXPECT_FALSE(loaded.report.skipped);
    ASSERT_EQ(loaded.scene().objects.size(), 1U) << "the other one has no tag";
    EXPECT_EQ(loaded.scene().objects[0].name, "tetra");
    EXPECT_EQ(loaded.scene().materials.at(0).stiffness_N_m, 321);
    EXPECT_EQ(loaded.scene().materials[0].softness.model, haptics::SoftnessModel::kWinkler);
    EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
  }
  EXPECT_TRUE(LoadTagged(Two(), "").report.skipped);
}

TEST(SceneNamedTags, CountOverTheFilesOwnAndForDescendants) {
  Model model = Two();
  model.json["nodes"][0]["extras"]["haptic"] = {{"stiffness", 100}, {"staticFriction", 0.7}};
  Loaded over = LoadTagged(model, R"({"tetra": {"stiffness": 321}})");
  ASSERT_TRUE(over.result.ok()) << over.result.error();
  EXPECT_EQ(over.scene().materials.at(0).stiffness_N_m, 321);
  EXPECT_EQ(over.scene().materials[0].static_friction, 0.7);
  model = Two();
  model.json["nodes"].push_back({{"name", "group"}, {"children", {0, 1}}});
  model.json["scenes"][0]["nodes"] = {2};
  Loaded group = LoadTagged(model, R"({"group": {"stiffness": 200}, "other": {"role": "ignore"}})");
  ASSERT_TRUE(group.result.ok()) << group.result.error();
  ASSERT_EQ(group.scene().objects.size(), 1U);
  EXPECT_EQ(group.scene().objects[0].name, "tetra");
}

TEST(SceneNamedTags, UnknownNamesAndKeysAreWarnedAbout) {
  const Loaded loaded = LoadTagged(Two(), R"({"tetra": {"stifness": 3}, "terta": {}, "clay": {"stiffness": 5}})");
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  const std::string all = loaded.Warnings();
  for (const char* part :
       {"tag \"tetra\"/stifness: is not a key of a haptic tag",
        "tag \"terta\": is of no node and no material of this file, and is not used; did you mean 'tetra'?",
        "tag \"clay\": is of no node and no material"}) {
    EXPECT_NE(all.find(part), std::string::npos) << part << " not in\n" << all;
  }
  EXPECT_EQ(loaded.report.warnings.size(), 3U) << all;
}

TEST(SceneNamedTags, ArePartOfTheCachesKey) {
  const TempFolder folder;
  CacheStore cache(folder.Path("cache"));
  LoadReport load;
  for (const char* tags : {"", R"({"a": {}})", R"({"a": {}})", R"({"b": {}})"}) {
    LoadOptions options;
    options.tags_by_name = tags;
    CachedPlace(&cache, "a.glb", options, {}).Keep(kCachedFromTriangles, std::vector<std::byte>(16), load);
  }
  EXPECT_EQ(cache.Usage().files, 3U);
}

}  // namespace test_scene_named_tags
}  // namespace omni::scene::test
