// KHR_node_visibility: what is not seen is felt only where its node is tagged itself.
#include <gtest/gtest.h>

#include "service/scene/drawn_scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_hidden {

const Json kHidden = Json::parse(R"({"KHR_node_visibility": {"visible": false}})");

// A visible tetrahedron, and one (node 1, child of node 2) that the test may hide.
Model Two() {
  Model model = Tetra();
  model.json["nodes"].push_back({{"name", "inner"}, {"mesh", 0}, {"translation", {0.02, 0, 0}}});
  model.json["nodes"].push_back({{"name", "outer"}, {"children", {1}}});
  model.json["scenes"][0]["nodes"] = {0, 2};
  return model;
}

std::string RowOf(const LoadReport& report, const std::string& pointer) {
  for (const ExplainRow& row : report.rows) {
    if (row.pointer == pointer) return row.why;
  }
  return "no row";
}

std::string Touched(Loaded& loaded) {
  if (!loaded.result.ok()) return loaded.result.error();
  std::string names;
  for (const haptics::InputObject& object : loaded.scene().objects) names += object.name + " ";
  return names;
}

TEST(SceneHidden, TouchAllLeavesHiddenNodesOut) {
  Model model = Two();
  for (const bool fit : {false, true}) {
    LoadOptions options = kTouchAll;
    options.fit = fit;
    for (const int node : {1, 2}) {
      Model hidden = model;
      hidden.json["nodes"][static_cast<std::size_t>(node)]["extensions"] = kHidden;
      Loaded loaded = LoadBytes(hidden.Bytes(), options);
      EXPECT_EQ(Touched(loaded), "tetra ") << "node " << node;
      EXPECT_NE(RowOf(loaded.report, "/nodes/1").find("hidden (KHR_node_visibility)"), std::string::npos);
    }
  }
  Loaded visible = LoadBytes(model.Bytes());
  EXPECT_EQ(Touched(visible), "tetra inner ");
  model.json["nodes"][1]["extensions"] = Json::parse(R"({"KHR_node_visibility": {"visible": true}})");
  Loaded said = LoadBytes(model.Bytes());
  EXPECT_EQ(Touched(said), "tetra inner ");
  model.json["nodes"][1]["extensions"] = Json::parse(R"({"KHR_node_visibility": {}})");
  Loaded silent = LoadBytes(model.Bytes());
  EXPECT_EQ(Touched(silent), "tetra inner ");
}

TEST(SceneHidden, OnlyATagOfItsOwnMakesAHiddenNodeTouchable) {
  Model model = Two();
  model.json["nodes"][2]["extensions"] = kHidden;
  model.json["nodes"][0]["extras"]["haptic"] = true;
  model.json["nodes"][2]["extras"]["haptic"] = {{"stiffness", 300}};
  Loaded inherited = LoadBytes(model.Bytes(), {});
  EXPECT_EQ(Touched(inherited), "tetra ");
  model.json["nodes"][1]["extras"]["haptic"] = true;
  Loaded own = LoadBytes(model.Bytes(), {});
  EXPECT_EQ(Touched(own), "tetra inner ");
  EXPECT_NE(RowOf(own.report, "/nodes/1").find("hidden (KHR_node_visibility) but tagged"), std::string::npos)
      << RowOf(own.report, "/nodes/1");
  model.json["nodes"][1].erase("extras");
  model.json["nodes"][1]["extensions"] = Json::parse(R"({"KHR_physics_rigid_bodies": {"collider": {}}})");
  Loaded collider = LoadBytes(model.Bytes(), {});
  EXPECT_EQ(Touched(collider), "tetra inner ") << "a collider is what a node collides by, seen or not";
  model.json["nodes"][1].erase("extensions");
  model.json["materials"][0]["extras"]["haptic"] = true;
  Loaded material = LoadBytes(model.Bytes(), {});
  EXPECT_EQ(Touched(material), "tetra ");
}

TEST(SceneHidden, IsNotDrawn) {
  Model model = Two();
  model.json["nodes"][1]["extensions"] = kHidden;
  const TempFolder folder;
  const auto drawn = LoadDrawnScene(folder.Write("a.glb", model.Bytes()));
  ASSERT_TRUE(drawn.ok()) << drawn.error();
  ASSERT_EQ(drawn->parts.size(), 1U);
  EXPECT_EQ(drawn->parts[0].name, "tetra");
}

TEST(SceneHidden, AWrongValueIsRefusedByPlace) {
  Model model = Two();
  model.json["nodes"][1]["extensions"] = Json::parse(R"({"KHR_node_visibility": {"visible": 0}})");
  const Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_FALSE(loaded.result.ok());
  EXPECT_NE(loaded.result.error().find("/nodes/1/extensions/KHR_node_visibility/visible: is 0"), std::string::npos)
      << loaded.result.error();
}

}  // namespace test_scene_hidden
}  // namespace omni::scene::test
