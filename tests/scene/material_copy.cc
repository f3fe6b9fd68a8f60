// Copies of scenes with other material numbers, judged by loading them again.
#include "service/scene/material_copy.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "service/base/files/whole_file.h"
#include "service/scene/glb_save.h"

namespace omni::scene {
namespace test_scene_material_copy {

haptics::SceneInput Load(const std::string& path, LoadReport& report) {
  auto input = LoadSceneFile(path, {.touch_untagged = true}, report);
  EXPECT_TRUE(input.ok()) << input.error();
  return input.ok() ? *input : haptics::SceneInput{};
}

class MaterialCopyTest : public testing::Test {
 protected:
  std::string Path(const std::string& name) const {
    return testing::TempDir() + "omni_copy_" + std::to_string(::getpid()) + name;
  }
  ~MaterialCopyTest() override {
    for (const char* name : {"a.glb", "b.glb"}) std::filesystem::remove(Path(name));
  }
  // Changes one material and loads the copy.
  haptics::SceneInput Change(const std::string& path, std::uint16_t material, const base::MaterialParameters& values) {
    LoadReport report;
    Load(path, report);
    const ChangedMaterial changed[] = {{material, values}};
    const auto copy = GlbWithMaterials(path, report.material_uses, changed);
    EXPECT_TRUE(copy.ok()) << copy.error();
    std::ofstream(Path("b.glb"), std::ios::binary) << (copy.ok() ? *copy : "");
    LoadReport again;
    return Load(Path("b.glb"), again);
  }
};

base::MaterialParameters Other(const haptics::Material& material) {
  base::MaterialParameters values = base::ParametersOf(material);
  values.stiffness_N_m = 123;
  values.dynamic_friction = 0.05;
  values.vibration_amplitude_N = 0.25;
  values.texture_amplitude_m = 1e-4;
  return values;
}

// Triangles and all other numbers stay.
TEST_F(MaterialCopyTest, ShippedScenesKeepEverythingElse) {
  for (const char* name : {"extrusion.glb", "dragon.glb", "racetrack.glb"}) {
    const std::string path = std::string(OMNI_SOURCE_DIR) + "/scenes/" + name;
    LoadReport report;
    const haptics::SceneInput before = Load(path, report);
    for (std::size_t m = 0; m < before.materials.size(); ++m) {
      const base::MaterialParameters wanted = Other(before.materials[m]);
      const haptics::SceneInput after = Change(path, static_cast<std::uint16_t>(m), wanted);
      ASSERT_EQ(after.objects.size(), before.objects.size());
      for (std::size_t i = 0; i < before.objects.size(); ++i) {
        EXPECT_EQ(after.objects[i].triangles, before.objects[i].triangles);
        for (std::size_t t = 0; t < before.objects[i].triangles.size(); ++t) {
          const std::uint16_t was = before.objects[i].triangle_material[t];
          const base::MaterialParameters is =
              base::ParametersOf(after.materials.at(after.objects[i].triangle_material[t]));
          const base::MaterialParameters expected = was == m ? wanted : base::ParametersOf(before.materials[was]);
          for (const base::MaterialField* field : base::kLiveFields) {
            ASSERT_DOUBLE_EQ(is.*field->live, expected.*field->live) << name << ' ' << field->key;
          }
          ASSERT_EQ(after.materials[after.objects[i].triangle_material[t]].sculpt.enabled,
                    before.materials[was].sculpt.enabled);
        }
      }
    }
  }
}

// Two objects with one glTF material but tags of their own: only the changed one changes.
TEST_F(MaterialCopyTest, SharedMaterialIsCopiedForTheChangedOne) {
  haptics::SceneInput input;
  input.materials.resize(2);
  input.materials[1].stiffness_N_m = 777;
  for (std::uint16_t i = 0; i < 2; ++i) {
    haptics::InputObject object;
    object.name = i == 0 ? "a" : "b";
    object.vertices_base_m = {{0.1 * i, 0, 0.05}, {0.1 * i + 0.02, 0, 0.05}, {0.1 * i, 0.02, 0.05}, {0.1 * i, 0, 0.07}};
    object.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    object.triangle_material.assign(4, i);
    input.objects.push_back(object);
  }
  ASSERT_TRUE(SaveGlb(Path("a.glb"), input).ok());
  LoadReport report;
  const haptics::SceneInput before = Load(Path("a.glb"), report);
  const std::uint16_t first = before.objects[0].triangle_material[0];
  const haptics::SceneInput after = Change(Path("a.glb"), first, Other(before.materials[first]));
  EXPECT_EQ(after.materials[after.objects[0].triangle_material[0]].stiffness_N_m, 123);
  EXPECT_EQ(after.materials[after.objects[1].triangle_material[0]].stiffness_N_m, 777);
}

TEST_F(MaterialCopyTest, WhatIsNoGlbIsNamed) {
  std::ofstream(Path("a.glb")) << "no model";
  const auto copy = GlbWithMaterials(Path("a.glb"), {}, {});
  ASSERT_FALSE(copy.ok());
  EXPECT_NE(copy.error().find(".glb"), std::string::npos);
  EXPECT_FALSE(GlbWithMaterials("/nowhere.glb", {}, {}).ok());
}

}  // namespace test_scene_material_copy
}  // namespace omni::scene
