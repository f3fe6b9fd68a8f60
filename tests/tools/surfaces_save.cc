// omni surfaces --save: which surfaces are written, where, and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <vector>

#include "service/protocol/surfaces/surface_memory.h"
#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"
#include "service/tools/common/command_line.h"
#include "service/tools/surfaces/surfaces.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_surfaces_save {

// A tetrahedron around (0, 0, 0.06), a little different for every seed.
PublishedSurfaces::Object SomeObject(const std::string& name, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> jitter(-0.001F, 0.001F);
  PublishedSurfaces::Object object{.name = name};
  object.copy.frame.t_ns = 1000 + static_cast<std::int64_t>(seed);
  for (const protocol::SurfacePoint& corner : {protocol::SurfacePoint{0.01F, 0.01F, 0.07F},
                                               {-0.01F, -0.01F, 0.07F},
                                               {-0.01F, 0.01F, 0.05F},
                                               {0.01F, -0.01F, 0.05F}}) {
    object.copy.vertices_base_m.push_back(
        {corner[0] + jitter(random), corner[1] + jitter(random), corner[2] + jitter(random)});
  }
  object.copy.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return object;
}

TEST(SurfacesSave, FileHasEverySurfaceAtItsPose) {
  const test::TempFolder folder;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> angle(-3, 3), shift(-0.02, 0.02);
    PublishedSurfaces surfaces;
    surfaces.objects = {SomeObject("still", seed), SomeObject("turned", seed + 100)};
    protocol::SurfaceFrame& frame = surfaces.objects[1].copy.frame;
    const double turn_rad = angle(random);  // about z
    frame.rotation_wxyz = {std::cos(turn_rad / 2), 0, 0, std::sin(turn_rad / 2)};
    frame.translation_m = {shift(random), shift(random), shift(random)};
    const base::Result<std::string> bytes = scene::GlbBytes(SceneOfSurfaces(surfaces));
    ASSERT_TRUE(bytes.ok()) << bytes.error();
    scene::LoadReport report;
    const auto loaded = scene::LoadSceneFile(folder.Write("saved.glb", *bytes), {}, report);
    ASSERT_TRUE(loaded.ok()) << loaded.error();
    ASSERT_EQ(loaded->objects.size(), 2U);
    EXPECT_EQ(loaded->objects[1].name, "turned");
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    for (std::size_t corner = 0; corner < 12; ++corner) {  // vertices may be in another order
      const auto at = [&](const auto& vertices, const auto& triangles) {
        return vertices[triangles[corner / 3][corner % 3]];
      };
      const auto& saved = surfaces.objects;
      const auto p = at(saved[1].copy.vertices_base_m, saved[1].copy.triangles);
      const base::Vec3 q = at(loaded->objects[1].vertices_base_m, loaded->objects[1].triangles);
      EXPECT_NEAR(q.x, c * double{p[0]} - s * double{p[1]} + frame.translation_m[0], 2e-8);
      EXPECT_NEAR(q.y, s * double{p[0]} + c * double{p[1]} + frame.translation_m[1], 2e-8);
      EXPECT_NEAR(q.z, double{p[2]} + frame.translation_m[2], 2e-8);
      EXPECT_NEAR(at(loaded->objects[0].vertices_base_m, loaded->objects[0].triangles).x,
                  double{at(saved[0].copy.vertices_base_m, saved[0].copy.triangles)[0]}, 2e-8);
    }
  }
}

TEST(SurfacesSave, OmitsObjectsWithoutASurface) {
  PublishedSurfaces surfaces;
  surfaces.objects = {SomeObject("clay", 1), {.name = "moved only", .copy = {}}};
  EXPECT_EQ(SceneOfSurfaces(surfaces).objects.size(), 1U);
  EXPECT_EQ(SavedText(surfaces), "1 object, 4 vertices at t_ns 1001");
  surfaces.objects.erase(surfaces.objects.begin());
  EXPECT_FALSE(scene::GlbBytes(SceneOfSurfaces(surfaces)).ok()) << "a file without anything is not written";
}

TEST(SurfacesSave, ReportsLargestDisplacementAndItsTime) {
  PublishedSurfaces surfaces;
  EXPECT_EQ(surfaces.MostDisplaced(), 0U);
  EXPECT_EQ(surfaces.LargestDisplacement_m(), 0);
  surfaces.objects = {SomeObject("a", 5), SomeObject("b", 3), SomeObject("c", 7)};
  surfaces.objects[1].copy.frame.largest_displacement_m = 0.0012346;
  surfaces.objects[2].copy.frame.largest_displacement_m = 0.0004;
  EXPECT_EQ(surfaces.MostDisplaced(), 1U);
  EXPECT_EQ(SavedText(surfaces), "3 objects, 12 vertices; largest displacement 1.235 mm (b) at t_ns 1003");
}

int StatusOf(const std::vector<const char*>& words, std::string* said) {
  testing::internal::CaptureStderr();
  const int status = RunCommandLine(static_cast<int>(words.size()), words.data());
  *said = testing::internal::GetCapturedStderr();
  return status;
}

TEST(SurfacesSave, FailsWithoutServiceOrOverExistingFile) {
  const test::TempFolder folder;
  const std::string socket = folder.Path("omnid.sock"), file = folder.Path("out.glb");
  std::string said;
  for (const char* how : {"--force", "--largest"}) {
    const std::vector<const char*> words{"omni", "surfaces", "--save", file.c_str(), how, "--socket", socket.c_str()};
    EXPECT_EQ(StatusOf(words, &said), kExitNoService);
    EXPECT_NE(said.find("to start it"), std::string::npos) << said;
    EXPECT_FALSE(std::filesystem::exists(file));
  }
  folder.Write("out.glb", "mine");
  EXPECT_EQ(StatusOf({"omni", "surfaces", "--save", file.c_str(), "--socket", socket.c_str()}, &said), kExitFailed);
  EXPECT_NE(said.find("out.glb: already exists"), std::string::npos) << said;
  EXPECT_EQ(std::filesystem::file_size(file), 4U);
  EXPECT_NE(StatusOf({"omni", "surfaces", "--largest"}, &said), kExitOk) << "there is nothing to write it to";
}

}  // namespace test_tools_surfaces_save
}  // namespace omni::tools
