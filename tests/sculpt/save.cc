// What was sculpted, saved, and loaded again.
#include <gtest/gtest.h>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_save {

SceneInput Sculpted(SculptEditor& editor) {
  Material hard;
  hard.stiffness_N_m = 777;
  Material soft;
  soft.softness.model = SoftnessModel::kWinkler;
  soft.softness.thickness_m = 0.0123;
  soft.extrude.enabled = true;
  soft.extrude.steps_out = 5;
  SceneInput scene;
  scene.name = "sculpted";
  scene.materials = {hard, soft};
  const Mesh mesh = editor.Snapshot();
  InputObject object;
  object.name = "clay";
  object.vertices_base_m = mesh.vertices;
  object.triangles = mesh.triangles;
  object.triangle_material = mesh.material;
  scene.objects.push_back(object);
  return scene;
}

InputObject TwoMaterials() {
  InputObject object = BumpyBall(12, 0.03);
  for (std::size_t t = 0; t < object.triangles.size(); ++t) object.triangle_material[t] = t % 7 == 0;
  return object;
}

TEST(SculptSaveTest, SavedSceneLoadsUnchanged) {
  const auto editor = EditorOf(TwoMaterials());
  Random random(6);
  Brush brush;
  brush.radius_m = 0.01;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(editor->Stroke(On(*editor, random.InBox(0.05)), brush, 0.004).ok());
  const SceneInput scene = Sculpted(*editor);
  const test::TempFolder folder;
  const std::string path = folder.Path("clay.glb");
  const base::Status saved = scene::SaveGlb(path, scene);
  ASSERT_TRUE(saved.ok()) << saved.error();
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  scene::LoadReport report;
  const auto loaded = scene::LoadSceneFile(path, {}, report);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  EXPECT_TRUE(report.warnings.empty()) << report.warnings.front();
  ASSERT_EQ(loaded->objects.size(), 1U);
  EXPECT_EQ(loaded->objects[0].name, "clay");
  EXPECT_EQ(loaded->objects[0].triangles.size(), scene.objects[0].triangles.size());
  std::array<std::size_t, 2> count{}, count_again{};
  for (const std::uint16_t m : scene.objects[0].triangle_material) ++count[m];
  for (const std::uint16_t m : loaded->objects[0].triangle_material) {
    ++count_again[loaded->materials[m].stiffness_N_m == 777 ? 0U : 1U];
  }
  EXPECT_EQ(count, count_again);
  for (const Material& m : loaded->materials) {
    if (m.stiffness_N_m == 777) continue;
    EXPECT_EQ(m.softness.model, SoftnessModel::kWinkler);
    EXPECT_EQ(m.softness.thickness_m, 0.0123);
    EXPECT_TRUE(m.extrude.enabled);
    EXPECT_EQ(m.extrude.steps_out, 5);
  }
  // The same surface, to single precision, and it can be sculpted on.
  const auto again = EditorOf(loaded->objects[0]);
  ASSERT_NE(again, nullptr);
  const ManifoldReport manifold = CheckManifold(again->mesh());
  EXPECT_TRUE(manifold.ok()) << manifold.problem;
  for (int k = 0; k < 200; ++k) {
    const Vec3 p = random.InBox(0.05);
    editor->Publish();
    EXPECT_LT(Norm(On(*again, p).position - On(*editor, p).position), 1e-7);
  }
}

TEST(SculptSaveTest, RejectsUnwritablePathsAndInvalidScenes) {
  const auto editor = EditorOf(TwoMaterials());
  SceneInput scene = Sculpted(*editor);
  EXPECT_NE(scene::SaveGlb("/nowhere/at/all.glb", scene).error().find("/nowhere/at/all.glb"), std::string::npos);
  scene.objects[0].vertices_base_m[3].x = std::nan("");
  EXPECT_FALSE(scene::GlbBytes(scene).ok());
  scene = Sculpted(*editor);
  scene.objects[0].triangles[0][1] = 1u << 30;
  EXPECT_FALSE(scene::GlbBytes(scene).ok());
  scene = Sculpted(*editor);
  scene.joystick.emplace();
  EXPECT_FALSE(scene::GlbBytes(scene).ok());
  scene = Sculpted(*editor);
  scene.materials.resize(1);
  EXPECT_FALSE(scene::GlbBytes(scene).ok());
  EXPECT_FALSE(scene::GlbBytes({}).ok());
}

}  // namespace test_sculpt_save
}  // namespace omni::haptics::sculpt
