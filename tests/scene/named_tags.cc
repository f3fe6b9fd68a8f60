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

// What the program that wrote the file does to tags is said where these are missing, and nowhere else.
TEST(SceneNamedTags, ProgramsThatDropTagsAreNamed) {
  const auto written_by = [](const char* generator) {
    Model model = Two();
    model.json["asset"]["generator"] = generator;
    return model;
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  for (const auto& [generator, remedy] :
       {std::pair("gltfpack 1.3", "/asset/generator: is gltfpack, which drops names and extras: -kn -km -ke keep"),
        std::pair("glTF-Transform v4.5.1", "`optimize` keeps these with --flatten false --join false")}) {
    Model model = written_by(generator);
    const Loaded untagged = LoadTagged(model, "");
    EXPECT_TRUE(untagged.report.skipped);
    EXPECT_TRUE(has(untagged.Warnings(), remedy)) << untagged.Warnings();
    EXPECT_TRUE(has(LoadTagged(model, R"({"tetra": {}, "lost": {}})").Warnings(), remedy));
    EXPECT_FALSE(has(LoadTagged(model, R"({"tetra": {}})").Warnings(), "generator")) << "nothing is missing";
    EXPECT_FALSE(has(LoadBytes(model.Bytes()).Warnings(), "generator")) << "all of it was requested";
    // Joined into one that is not touched.
    model.json["nodes"][0]["extras"]["haptic"] = "track";
    const Loaded nothing = LoadTagged(model, "");
    ASSERT_FALSE(nothing.result.ok());
    EXPECT_TRUE(has(nothing.result.error(), "has nothing to touch")) << nothing.result.error();
    EXPECT_TRUE(has(nothing.result.error(), generator == std::string("gltfpack 1.3") ? "-kn -km -ke" : "--join false"));
  }
  EXPECT_FALSE(has(LoadTagged(written_by("Blender"), "").Warnings(), "generator"));
  Model odd = written_by("");
  odd.json["asset"]["generator"] = 7;
  EXPECT_TRUE(LoadTagged(odd, "").report.skipped);
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
