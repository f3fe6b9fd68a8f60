// What haptic tags mean, wherever a file has them.
#include <gtest/gtest.h>

#include <cmath>

#include "service/scene/tags/haptic_keys.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_tags {

bool Has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(SceneTags, UntaggedFileGetsTheDefaultMaterial) {
  Loaded loaded = LoadBytes(Tetra().Bytes());
  ASSERT_TRUE(loaded.result.ok());
  EXPECT_EQ(loaded.scene().materials[0].stiffness_N_m, haptics::Material{}.stiffness_N_m);
  EXPECT_FALSE(loaded.scene().materials[0].extrude.enabled);
  EXPECT_TRUE(Has(loaded.report.rows[0].why, "default material")) << loaded.report.rows[0].why;
}

TEST(SceneTags, UntaggedObjectsAreSkippedIfAnyIsTagged) {
  Model model = Tetra();
  model.json["nodes"].push_back({{"mesh", 0}, {"name", "tagged"}, {"extras", {{"haptic", true}}}});
  model.json["scenes"][0]["nodes"] = {0, 1};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok());
  ASSERT_EQ(loaded.scene().objects.size(), 1U);
  EXPECT_EQ(loaded.scene().objects[0].name, "tagged");
}

TEST(SceneTags, EveryKeyReachesItsField) {
  for (const auto& row : base::kMaterialFields) {
    // In the middle of the range, friction apart (static >= dynamic): a value that is not the default.
    const double value = row.member.whole ? 3 : row.minimum + 0.37 * (row.maximum - row.minimum);
    Model model = Tetra();
    model.json["nodes"][0]["extras"] = {{"haptic." + std::string(row.key), value}, {"haptic.staticFriction", 2}};
    if (row.key == "staticFriction") model.json["nodes"][0]["extras"] = {{"haptic.staticFriction", value}};
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok()) << row.key;
    EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
    EXPECT_DOUBLE_EQ(row.Get(loaded.scene().materials[0]), value) << row.key;
    EXPECT_NE(row.Get(haptics::Material{}), value) << row.key << ": the default proves nothing";
  }
}

TEST(SceneTags, PrecedenceOfTagPlacesAppliesPerKey) {
  Model model = Tetra();
  const auto put = [&model](int places) {
    model = Tetra();
    Json& json = model.json;
    json["nodes"] = Json::parse(R"([{"children": [1]}, {"mesh": 0}])");
    const auto all = [](double v) {
      return Json{{"stiffness", v}, {"staticFriction", v / 1000}, {"damping", v / 1000}};
    };
    if (places >= 1) json["nodes"][0]["extras"]["haptic"] = all(100);
    if (places >= 2) json["nodes"][1]["extras"]["haptic"] = all(200);
    if (places >= 3) json["meshes"][0]["extras"]["haptic"] = all(300);
    if (places >= 4) json["materials"][0]["extras"]["haptic"] = all(400);
    if (places >= 5) {
      json["extensions"]["KHR_physics_rigid_bodies"]["physicsMaterials"] = Json::array({{{"staticFriction", 0.5}}});
      json["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["collider"]["physicsMaterial"] = 0;
    }
    if (places >= 6) {
      json["extensions"]["MPEG_haptic_material"]["materials"] =
          Json::array({{{"extensions", {{"OMNI_haptic_material", all(600)}}}},
                       {{"extensions", {{"OMNI_haptic_material", all(700)}}}}});
      json["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
    }
    if (places >= 7) json["materials"][0]["extensions"]["OMNI_haptic_material"]["material"] = 1;
    if (places >= 8) json["materials"][0]["extensions"]["OMNI_haptic_material"]["stiffness"] = 800;
  };
  const double stiffness[] = {400, 100, 200, 300, 400, 400, 600, 700, 800};
  const double friction[] = {0.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.7};
  for (int places = 0; places <= 8; ++places) {
    put(places);
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
    EXPECT_EQ(loaded.scene().materials[0].stiffness_N_m, stiffness[places]) << places;
    EXPECT_EQ(loaded.scene().materials[0].static_friction, friction[places]) << places;
  }
}

TEST(SceneTags, ReadsOlderSpellingOfTheMpegExtension) {
  Model model = Tetra();
  model.json["extensions"]["MPEG_material_haptic"]["materials"] = Json::parse(
      R"([{"stiffness": [{"texture": {"index": 0}}], "extensions": {"OMNI_haptic_material": {"stiffness": 123}}}])");
  model.json["meshes"][0]["extensions"]["MPEG_material_haptic"]["hapticMaterialIndex"] = 0;
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_EQ(loaded.scene().materials[0].stiffness_N_m, 123);
  EXPECT_TRUE(Has(loaded.Warnings(), "/extensions/MPEG_material_haptic/materials/0/stiffness/0: is not used: "))
      << "there is no texture 0";
}

TEST(SceneTags, OutOfRangeValuesAreClampedWithAWarning) {
  for (const auto& row : base::kMaterialFields) {
    for (const double value : {row.minimum - 1, row.maximum * 2 + 1}) {
      Model model = Tetra();
      const std::string key = "haptic." + std::string(row.key);
      model.json["nodes"][0]["extras"][key] = value;
      Loaded loaded = LoadBytes(model.Bytes());
      ASSERT_TRUE(loaded.result.ok());
      EXPECT_TRUE(Has(loaded.Warnings(), "model.glb: /nodes/0/extras/" + key + ": is ")) << loaded.Warnings();
      const double got = row.Get(loaded.scene().materials[0]);
      EXPECT_TRUE(got >= row.minimum && got <= row.maximum) << row.key << " " << got;
    }
  }
}

TEST(SceneTags, UnknownKeysAndWrongTypesWarnAndKeepDefaults) {
  Model model = Tetra();
  model.json["nodes"][0]["extras"]["haptic"] =
      Json::parse(R"({"stifness": 5, "stiffness": "hard", "damping": null, "softness": 7, "magnet": {"range": []},
                      "role": "ghost", "doubleSided": "yes", "extrude": {"steps": 1}, "deadZone": 1, "vibration": 3})");
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  for (const char* key : {"stifness", "stiffness", "damping", "softness", "magnet/range", "role", "doubleSided",
                          "extrude/steps", "deadZone", "vibration"}) {
    EXPECT_TRUE(Has(loaded.Warnings(), std::string("/nodes/0/extras/haptic/") + key + ": ")) << key << "\n"
                                                                                             << loaded.Warnings();
  }
  EXPECT_EQ(loaded.scene().materials[0].stiffness_N_m, 400);
}

TEST(SceneTags, DynamicFrictionStaysBelowStatic) {
  Model model = Tetra();
  model.json["nodes"][0]["extras"]["haptic"] = {{"staticFriction", 0.2}};
  Loaded quiet = LoadBytes(model.Bytes());
  ASSERT_TRUE(quiet.result.ok());
  EXPECT_EQ(quiet.scene().materials[0].dynamic_friction, 0.2);
  EXPECT_TRUE(quiet.report.warnings.empty()) << quiet.Warnings();
  model.json["nodes"][0]["extras"]["haptic"]["dynamicFriction"] = 0.9;
  Loaded loud = LoadBytes(model.Bytes());
  EXPECT_EQ(loud.scene().materials[0].dynamic_friction, 0.2);
  EXPECT_TRUE(Has(loud.Warnings(), "dynamicFriction 0.9 is above staticFriction 0.2"));
}

TEST(SceneTags, ReadsEveryFormOfExtrudeAndSoftness) {
  const struct {
    const char* tag;
    bool extrude;
    haptics::SoftnessModel softness;
  } kRows[] = {{R"({"extrude": true})", true, haptics::SoftnessModel::kNone},
               {R"({"extrude": {"step": 0.002}})", true, haptics::SoftnessModel::kNone},
               {R"({"extrude": false})", false, haptics::SoftnessModel::kNone},
               {R"({"softness": "tet"})", false, haptics::SoftnessModel::kTet},
               {R"({"softness": {"youngModulus": 30000}})", false, haptics::SoftnessModel::kWinkler},
               {R"({"softness": {"model": "none", "youngModulus": 30000}})", false, haptics::SoftnessModel::kNone},
               {R"("{\"extrude\": true, \"softness\": \"winkler\"}")", true, haptics::SoftnessModel::kWinkler}};
  for (const auto& row : kRows) {
    Model model = Tetra();
    model.json["nodes"][0]["extras"]["haptic"] = Json::parse(row.tag);
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok()) << row.tag;
    EXPECT_EQ(loaded.scene().materials[0].extrude.enabled, row.extrude) << row.tag;
    EXPECT_EQ(loaded.scene().materials[0].softness.model, row.softness) << row.tag;
    EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
  }
}

TEST(SceneTags, ReadsFlatDottedKeys) {
  Model model = Tetra();
  model.json["materials"][0]["extras"] =
      Json::parse(R"({"haptic.extrude": 1, "haptic.softness.model": "winkler", "haptic.stiffness": 250, "colour": 3})");
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok());
  EXPECT_TRUE(loaded.scene().materials[0].extrude.enabled);
  EXPECT_EQ(loaded.scene().materials[0].softness.model, haptics::SoftnessModel::kWinkler);
  EXPECT_EQ(loaded.scene().materials[0].stiffness_N_m, 250);
  EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
}

TEST(SceneTags, RolesDecideWhatANodeBecomes) {
  Model model = Tetra();
  model.json["nodes"] = Json::parse(R"([
    {"name": "solid", "mesh": 0, "extras": {"haptic": {"doubleSided": true}}},
    {"name": "wall", "mesh": 0, "extras": {"haptic": "wall"}},
    {"name": "road", "mesh": 0, "extras": {"haptic": "track"}},
    {"name": "hidden", "children": [4], "extras": {"haptic.role": "ignore"}},
    {"name": "child of hidden", "mesh": 0},
    {"name": "stick", "translation": [0.001, 0.06, -0.002],
     "extras": {"haptic": {"role": "joystick", "stiffness": 80, "range": 0.01, "deadZone": 0.02}}},
    {"name": "car", "mesh": 0, "translation": [0, 0.047, 0], "rotation": [0, 0.70710678, 0, 0.70710678],
     "extras": {"haptic": {"role": "vehicle", "radius": 0.003, "stiffness": 5}}},
    {"name": "second car", "extras": {"haptic": "vehicle"}},
    {"name": "half way", "translation": [0.02, 0.047, 0], "rotation": [0, 1, 0, 0],
     "extras": {"haptic": {"role": "checkpoint", "width": 0.01}}}])");
  model.json["scenes"][0]["nodes"] = {0, 1, 2, 3, 5, 6, 7, 8};
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  haptics::SceneInput& scene = loaded.scene();
  ASSERT_EQ(scene.objects.size(), 2U);
  EXPECT_TRUE(scene.objects[0].double_sided);
  EXPECT_FALSE(scene.objects[0].car_wall);
  EXPECT_TRUE(scene.objects[1].car_wall);
  EXPECT_TRUE(scene.objects[1].collidable);
  ASSERT_TRUE(scene.joystick.has_value());
  EXPECT_NEAR(scene.joystick->centre_base_m.x, 0.001, 1e-12);
  EXPECT_NEAR(scene.joystick->centre_base_m.y, 0.002, 1e-12);
  EXPECT_NEAR(scene.joystick->centre_base_m.z, 0.06, 1e-12);
  EXPECT_EQ(scene.joystick->stiffness_N_m, 80);
  EXPECT_LT(scene.joystick->dead_zone_m, scene.joystick->range_m);
  ASSERT_TRUE(scene.vehicle.has_value());
  EXPECT_EQ(scene.vehicle->radius_m, 0.003);
  EXPECT_NEAR(scene.vehicle->start_base_m.z, 0.047, 1e-12);
  EXPECT_NEAR(scene.vehicle->start_heading_rad, std::acos(0.0), 1e-7);  // x turned to glTF's -z: the base's +y
  EXPECT_TRUE(Has(loaded.Warnings(), "/nodes/7: is a second vehicle"));
  ASSERT_EQ(scene.vehicle->checkpoint_count, 1);
  EXPECT_EQ(scene.vehicle->checkpoints[0].width_m, 0.01);
  EXPECT_NEAR(scene.vehicle->checkpoints[0].position_base_m.x, 0.02, 1e-12);
  EXPECT_NEAR(std::abs(scene.vehicle->checkpoints[0].heading_rad), 2 * std::acos(0.0), 1e-7) << "against x";
  EXPECT_TRUE(Has(loaded.Warnings(), "deadZone 0.02 m must be below range 0.01 m"));
  EXPECT_TRUE(Has(loaded.Warnings(), "/nodes/6/extras/haptic/stiffness: is not a key"));
}

// The pen's nib, unless the scene says otherwise.
TEST(SceneTags, TipIsTheNibWhereTheSceneDoesNotSay) {
  Model model = Tetra();
  EXPECT_EQ(LoadBytes(model.Bytes()).scene().tip_radius_m, 0.0015);
  EXPECT_EQ(LoadBytes(model.Bytes(), {.touch_untagged = true, .tip_radius_m = 0}).scene().tip_radius_m, 0);
  EXPECT_EQ(LoadBytes(model.Bytes(), {.touch_untagged = true, .tip_radius_m = 0.001}).scene().tip_radius_m, 0.001);
  model.json["scenes"][0]["extras"]["haptic"]["tip"]["radius"] = "fine";
  Loaded wrong = LoadBytes(model.Bytes());
  EXPECT_EQ(wrong.scene().tip_radius_m, 0.0015);
  EXPECT_TRUE(Has(wrong.Warnings(), "/scenes/0/extras/haptic/tip/radius"));
  model.json["scenes"][0]["extras"]["haptic"]["tip"]["radius"] = 0;
  EXPECT_EQ(LoadBytes(model.Bytes()).scene().tip_radius_m, 0) << "a point";
}

TEST(SceneTags, ReadsSculptKinematicTipAndFibreKeys) {
  Model model = Tetra();
  model.json["scenes"][0]["extras"]["haptic"]["tip"]["radius"] = 0.0025;
  model.json["nodes"][0]["rotation"] = {0, 0, 0.7071067811865476, 0.7071067811865476};  // x -> y of the file
  model.json["nodes"][0]["extras"]["haptic"] = Json::parse(R"({
    "sculptable": {"radius": 0.008, "falloff": "linear", "symmetry": "x", "snap": 0.002, "resistance": 300},
    "softness": {"fibreRatio": 4, "fibreDirection": [2, 0, 0], "hardening": 3}})");
  Loaded loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_EQ(loaded.Warnings(), "");
  EXPECT_EQ(loaded.scene().tip_radius_m, 0.0025);
  const haptics::Material& m = loaded.scene().materials[0];
  EXPECT_TRUE(m.sculpt.enabled);
  EXPECT_EQ(m.sculpt.radius_m, 0.008);
  EXPECT_EQ(m.sculpt.falloff, haptics::Falloff::kLinear);
  EXPECT_EQ(m.sculpt.symmetry, haptics::Symmetry::kX);
  EXPECT_EQ(m.sculpt.snap_m, 0.002);
  EXPECT_EQ(m.sculpt.resistance_N_m, 300);
  EXPECT_EQ(m.sculpt.grab_force_N, haptics::Sculpt{}.grab_force_N);
  EXPECT_EQ(m.softness.fibre_ratio, 4);
  EXPECT_EQ(m.softness.hardening, 3);
  EXPECT_NEAR(m.softness.fibre_direction_base[2], 1, 1e-7) << "the file's y is up: the base's z";
  EXPECT_FALSE(loaded.scene().objects[0].kinematic);

  // Flat keys, as an editor writes them.
  model = Tetra();
  model.json["scenes"][0]["extras"]["haptic.tip.radius"] = 0.5;
  model.json["nodes"][0]["extras"] = {{"haptic.kinematic", 1}, {"haptic.sculptable.falloff", "steep"}};
  loaded = LoadBytes(model.Bytes());
  ASSERT_TRUE(loaded.result.ok());
  EXPECT_EQ(loaded.scene().tip_radius_m, 0.01);
  EXPECT_TRUE(Has(loaded.Warnings(), "/scenes/0/extras/haptic.tip.radius: is 0.5, must be from 0 to 0.01 m"));
  EXPECT_TRUE(Has(loaded.Warnings(), "must be one of constant, linear, smooth"));
  EXPECT_TRUE(loaded.scene().objects[0].kinematic);
}

TEST(SceneTags, ContradictoryTagsAreResolvedWithAWarning) {
  struct Case {
    const char* tag;
    const char* warning;
    bool sculpt, extrude, tet;
  };
  const Case cases[] = {
      {R"({"sculptable": true, "softness": "tet"})", "sculptable and softness tet; sculptable wins", true, false,
       false},
      {R"({"sculptable": true, "extrude": true})", "sculptable and extrudable; sculptable wins", true, false, false},
      {R"({"sculptable": true, "kinematic": true})", "kinematic and sculptable; kinematic wins", false, false, false},
      {R"({"kinematic": true, "extrude": true})", "kinematic and extrudable", false, false, false},
      {R"({"kinematic": true, "softness": "tet"})", "", false, false, true},
  };
  for (const Case& c : cases) {
    Model model = Tetra();
    model.json["nodes"][0]["extras"]["haptic"] = Json::parse(c.tag);
    Loaded loaded = LoadBytes(model.Bytes());
    ASSERT_TRUE(loaded.result.ok());
    EXPECT_TRUE(Has(loaded.Warnings(), c.warning)) << c.tag << "\n" << loaded.Warnings();
    EXPECT_EQ(loaded.Warnings().empty(), std::string(c.warning).empty()) << c.tag;
    const haptics::Material& m = loaded.scene().materials[0];
    EXPECT_EQ(m.sculpt.enabled, c.sculpt) << c.tag;
    EXPECT_EQ(m.extrude.enabled, c.extrude) << c.tag;
    EXPECT_EQ(m.softness.model == haptics::SoftnessModel::kTet, c.tet) << c.tag;
  }
}

// A row of the schema, found by its dotted path. Numbers: tests/scenes/keys_page.cc.
const Json* SchemaRow(const Json& properties, const std::string& path) {
  const std::size_t dot = path.find('.');
  const Json& property = properties.at(path.substr(0, dot));
  if (dot == std::string::npos) return &property;
  const Json& object = property.contains("oneOf") ? property["oneOf"].back() : property;
  return SchemaRow(object.at("properties"), path.substr(dot + 1));
}

TEST(SceneTags, SchemaAndDocumentListEnumWords) {
  const std::string root = OMNI_SOURCE_DIR;
  const Json schema = Json::parse(ReadAll(root + "/scenes/schema/OMNI_haptic_material.schema.json"));
  const std::string page = ReadAll(root + "/docs/scenes.md");
  for (const char* word : {"`kinematic`", "`sculptable.falloff`", "`sculptable.symmetry`", "`softness.fibreDirection`",
                           "`tip.radius`", "constant, linear, smooth", "none, x, y, z"}) {
    EXPECT_TRUE(Has(page, word)) << word;
  }
  const Json& sculptable = *SchemaRow(schema.at("properties"), "sculptable");
  EXPECT_EQ(sculptable["oneOf"].back()["properties"]["falloff"]["enum"], Json({"constant", "linear", "smooth"}));
  EXPECT_EQ(sculptable["oneOf"].back()["properties"]["symmetry"]["enum"], Json({"none", "x", "y", "z"}));
  EXPECT_EQ(SchemaRow(schema.at("$defs"), "tip.radius")->at("maximum"), 0.01);
  EXPECT_EQ(SchemaRow(schema.at("properties"), "kinematic")->at("type"), "boolean");
  EXPECT_EQ(SchemaRow(schema.at("properties"), "softness.fibreDirection")->at("minItems"), 3);
}

TEST(SceneTags, AKeyOfTheWrongCaseIsPointedOut) {
  for (const char* key : {"Haptic", "HAPTIC", "Haptic.stiffness", "hApTiC.role"}) {
    Model model = Tetra();
    model.json["nodes"][0]["extras"][key] = 500;
    const Loaded loaded = LoadBytes(model.Bytes());
    EXPECT_NE(
        loaded.Warnings().find("/nodes/0/extras/" + std::string(key) + ": is no haptic tag: the key is \"haptic\""),
        std::string::npos)
        << key << ": " << loaded.Warnings();
  }
  for (const char* key : {"haptics", "Haptical", "hap", "Happic", "Hapti"}) {
    Model model = Tetra();
    model.json["nodes"][0]["extras"][key] = 500;
    EXPECT_TRUE(LoadBytes(model.Bytes()).report.warnings.empty()) << key;
  }
}

}  // namespace test_scene_tags
}  // namespace omni::scene::test
