// What the page draws of a scene is where omnid has it.
#include "service/monitor/view/scene_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "service/scene/glb_save.h"

namespace omni::monitor {
namespace test_monitor_scene_view {

namespace fs = std::filesystem;

std::string Shipped(const std::string& name) { return std::string(OMNI_SOURCE_DIR) + "/scenes/" + name; }

struct Bounds {
  std::array<double, 3> lower{1e9, 1e9, 1e9}, upper{-1e9, -1e9, -1e9};
  void Add(double x, double y, double z) {
    const double v[3] = {x, y, z};
    for (std::size_t i = 0; i < 3; ++i) {
      lower[i] = std::min(lower[i], v[i]);
      upper[i] = std::max(upper[i], v[i]);
    }
  }
};

// Every object that is touched is drawn, within a tenth of a millimetre of where it is touched.
TEST(SceneView, ShippedScenesAreDrawnWhereTheyAreTouched) {
  for (const char* name : {"extrusion.glb", "dragon.glb", "racetrack.glb"}) {
    const auto view = LoadSceneView(Shipped(name), name, {});
    ASSERT_TRUE(view.ok()) << view.error();
    scene::LoadReport report;
    const auto input = scene::LoadSceneFile(Shipped(name), {}, report);
    ASSERT_TRUE(input.ok());
    for (std::size_t object = 0; object < input->objects.size(); ++object) {
      Bounds touched, drawn;
      for (const base::Vec3& v : input->objects[object].vertices_base_m) touched.Add(v.x, v.y, v.z);
      for (const ViewPart& part : view->parts) {
        if (part.object != static_cast<std::int32_t>(object)) continue;
        for (const auto& p : part.shape.positions) drawn.Add(p[0], p[1], p[2]);
      }
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(drawn.lower[i], touched.lower[i], 1e-4) << name << ' ' << input->objects[object].name;
        EXPECT_NEAR(drawn.upper[i], touched.upper[i], 1e-4) << name << ' ' << input->objects[object].name;
      }
    }
  }
}

TEST(SceneView, ShapesAreWhole) {
  for (const char* name : {"extrusion.glb", "dragon.glb", "racetrack.glb"}) {
    const auto view = LoadSceneView(Shipped(name), name, {});
    ASSERT_TRUE(view.ok()) << view.error();
    for (const ViewPart& part : view->parts) {
      EXPECT_EQ(part.shape.normals.size(), part.shape.positions.size());
      for (const auto& triangle : part.shape.triangles) {
        for (const std::uint32_t v : triangle) ASSERT_LT(v, part.shape.positions.size());
      }
    }
    EXPECT_FALSE(view->materials.empty());
  }
}

haptics::SceneInput Tetrahedra(int count, const std::string& name, double size_m) {
  haptics::SceneInput input;
  input.materials.resize(1);
  for (int i = 0; i < count; ++i) {
    haptics::InputObject object;
    object.name = name;
    const double x = 3 * i * size_m;
    object.vertices_base_m = {{x, 0, 0}, {x + size_m, 0, 0}, {x, size_m, 0}, {x, 0, size_m}};
    object.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    object.triangle_material.assign(4, 0);
    input.objects.push_back(object);
  }
  return input;
}

class SceneViewFile : public testing::Test {
 protected:
  std::string Save(const haptics::SceneInput& input) {
    path_ = testing::TempDir() + "omni_scene_view_" + std::to_string(::getpid()) + ".glb";
    const base::Status saved = scene::SaveGlb(path_, input);
    EXPECT_TRUE(saved.ok()) << saved.error();
    return path_;
  }
  ~SceneViewFile() override { fs::remove(path_); }
  std::string path_;
};

// It drives: the page draws it where it is, not where it started.
TEST(SceneView, CarIsNoPart) {
  const auto view = LoadSceneView(Shipped("racetrack.glb"), "racetrack.glb", {});
  ASSERT_TRUE(view.ok()) << view.error();
  for (const ViewPart& part : view->parts) EXPECT_NE(part.name, "car");
  EXPECT_GT(view->parts.size(), 3U);
}

// Two nodes of one name: what is drawn is what is touched, object by object.
TEST_F(SceneViewFile, EqualNamesDoNotMixObjects) {
  const auto view = LoadSceneView(Save(Tetrahedra(2, "same", 0.02)), "two.glb", {});
  ASSERT_TRUE(view.ok()) << view.error();
  ASSERT_EQ(view->parts.size(), 2U);
  EXPECT_EQ(view->parts[0].object, 0);
  EXPECT_EQ(view->parts[1].object, 1);
  EXPECT_NEAR(view->parts[1].shape.positions[0][0], 0.06, 1e-6);
}

// A model of any size comes into reach; scale and offset say how, for omnid to do the same.
TEST_F(SceneViewFile, FitReportsWhatItDid) {
  for (const double size_m : {0.001, 0.02, 3.0}) {
    const std::string path = Save(Tetrahedra(1, "large", size_m));
    scene::LoadOptions options;
    options.touch_untagged = options.fit = true;
    const auto view = LoadSceneView(path, "large.glb", options);
    ASSERT_TRUE(view.ok()) << view.error();
    scene::LoadReport report;
    const auto authored = scene::LoadSceneFile(path, {.touch_untagged = true}, report);
    const auto fitted = scene::LoadSceneFile(path, options, report);
    ASSERT_TRUE(authored.ok() && fitted.ok());
    for (std::size_t i = 0; i < fitted->objects[0].vertices_base_m.size(); ++i) {
      const base::Vec3& a = authored->objects[0].vertices_base_m[i];
      const base::Vec3& f = fitted->objects[0].vertices_base_m[i];
      EXPECT_NEAR(view->scale * a.x + view->offset_m.x, f.x, 1e-9);
      EXPECT_NEAR(view->scale * a.y + view->offset_m.y, f.y, 1e-9);
      EXPECT_NEAR(view->scale * a.z + view->offset_m.z, f.z, 1e-9);
    }
    Bounds drawn;
    for (const auto& p : view->parts.at(0).shape.positions) drawn.Add(p[0], p[1], p[2]);
    EXPECT_NEAR(drawn.upper[0] - drawn.lower[0], 0.05, 0.011) << "50 mm, or less for its height";
  }
}

// An application's file may scale, turn and move its scene: what is seen goes along.
TEST(SceneView, ScaledAndMovedScenesAreDrawnWhereTheyAreTouched) {
  for (const bool z_up : {false, true}) {
    scene::LoadOptions options;
    options.z_up = z_up;
    options.scale = 0.5;
    options.offset_base_m = {0.01, -0.02, 0.03};
    const auto view = LoadSceneView(Shipped("extrusion.glb"), "extrusion.glb", options);
    scene::LoadReport report;
    const auto input = scene::LoadSceneFile(Shipped("extrusion.glb"), options, report);
    ASSERT_TRUE(view.ok() && input.ok());
    Bounds touched, drawn;
    for (const base::Vec3& v : input->objects[0].vertices_base_m) touched.Add(v.x, v.y, v.z);
    for (const ViewPart& part : view->parts) {
      for (const auto& p : part.shape.positions) drawn.Add(p[0], p[1], p[2]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(drawn.lower[i], touched.lower[i], 1e-4);
      EXPECT_NEAR(drawn.upper[i], touched.upper[i], 1e-4);
    }
    EXPECT_EQ(view->z_up, z_up);
  }
}

TEST(SceneView, FailsWithTheFileAndTheReason) {
  const auto view = LoadSceneView("/nowhere/x.glb", "x.glb", {});
  ASSERT_FALSE(view.ok());
  EXPECT_NE(view.error().find("/nowhere/x.glb"), std::string::npos);
}

TEST(SceneLoads, LastRequestIsTheOneThatIsLoaded) {
  SceneLoads loads;
  loads.Request({.number = 1, .path = Shipped("extrusion.glb"), .name = "a"});
  loads.Request({.number = 2, .path = Shipped("dragon.glb"), .name = "b"});
  std::optional<LoadedView> loaded;
  while (!loaded) loaded = loads.Poll();
  EXPECT_EQ(loaded->number, 2U);
  ASSERT_NE(loaded->view, nullptr);
  EXPECT_EQ(loaded->view->name, "b");
}

}  // namespace test_monitor_scene_view
}  // namespace omni::monitor
