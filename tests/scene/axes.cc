// Which axis of a file is up: y, or z where the options say so.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "service/scene/cache/cache_store.h"
#include "service/scene/drawn_scene.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_axes {

const LoadOptions kZUp{.touch_untagged = true, .z_up = true};

// The tetrahedron of an exporter that leaves z up: (x, y, z) of the base are those of the file.
Model TetraZUp() {
  Model model = Tetra();
  std::vector<float> positions = TetraPositions();
  for (std::size_t k = 0; k < positions.size(); k += 3) {
    const float y = positions[k + 1];
    positions[k + 1] = -positions[k + 2];
    positions[k + 2] = y;
  }
  model.bin = Bytes(positions) + Bytes(TetraIndices());
  return model;
}

std::vector<base::Vec3> Vertices(Loaded& loaded) {
  EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
  return loaded.result.ok() ? loaded.scene().objects.at(0).vertices_base_m : std::vector<base::Vec3>();
}

TEST(SceneAxes, ZUpIsTheSameSolidAsYUp) {
  Loaded y_up = LoadBytes(Tetra().Bytes()), z_up = LoadBytes(TetraZUp().Bytes(), kZUp);
  const std::vector<base::Vec3> expected = Vertices(y_up), turned = Vertices(z_up);
  ASSERT_EQ(turned.size(), expected.size());
  for (std::size_t i = 0; i < turned.size(); ++i) EXPECT_LT(Norm(turned[i] - expected[i]), 1e-12);
  EXPECT_NEAR(SignedVolume6(z_up.scene().objects[0]), 1e-6, 1e-12);
  EXPECT_TRUE(z_up.report.warnings.empty()) << z_up.Warnings();
}

TEST(SceneAxes, JoystickVehicleAndChildrenTurnToo) {
  Model model = Tetra();
  model.json["nodes"] = Json::parse(R"([{"children": [1, 2, 3], "translation": [0.01, 0, 0]},
    {"mesh": 0, "translation": [0, 0, 0.06], "extras": {"haptic": true}},
    {"translation": [0, 0.002, 0.055], "extras": {"haptic": "joystick"}},
    {"translation": [0, 0.003, 0.05], "rotation": [0, 0, 0.70710678, 0.70710678], "extras": {"haptic": "vehicle"}}])");
  Loaded loaded = LoadBytes(model.Bytes(), kZUp);
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_LT(Norm(loaded.scene().joystick->centre_base_m - base::Vec3{0.01, 0.002, 0.055}), 1e-9);
  EXPECT_LT(Norm(loaded.scene().vehicle->start_base_m - base::Vec3{0.01, 0.003, 0.05}), 1e-9);
  EXPECT_NEAR(loaded.scene().vehicle->start_heading_rad, std::acos(0.0), 1e-6) << "about the file's z axis";
}

TEST(SceneAxes, FitAndPicturesTurnToo) {
  const TempFolder folder;
  const std::string path = folder.Write("model.glb", TetraZUp().Bytes());
  LoadOptions y_fit = kTouchAll, z_fit = kZUp;
  y_fit.fit = z_fit.fit = true;
  Loaded y_up = LoadBytes(Tetra().Bytes(), y_fit), z_up = Load(path, z_fit);
  const std::vector<base::Vec3> expected = Vertices(y_up), turned = Vertices(z_up);
  ASSERT_EQ(turned.size(), expected.size());
  for (std::size_t i = 0; i < turned.size(); ++i) EXPECT_LT(Norm(turned[i] - expected[i]), 1e-12);
  const auto drawn = LoadDrawnScene(path, true);
  ASSERT_TRUE(drawn.ok()) << drawn.error();
  double highest = 0;
  for (const base::Vec3& p : drawn->parts.at(0).positions_base_m) highest = std::max(highest, p.z);
  EXPECT_NEAR(highest, 0.055, 1e-8);
}

TEST(SceneAxes, TheAxisIsPartOfTheCachesKey) {
  const TempFolder folder;
  CacheStore cache(folder.Path("cache"));
  const Digest bytes{};
  std::vector<std::byte> block(16);
  LoadReport load;
  haptics::BuildReport build;
  CachedPlace(&cache, "a.glb", kTouchAll, bytes).Keep(kCachedFromTriangles, block, load);
  EXPECT_EQ(cache.Usage().files, 1U);
  CachedPlace(&cache, "a.glb", kTouchAll, bytes).Keep(kCachedFromTriangles, block, load);
  EXPECT_EQ(cache.Usage().files, 1U) << "the same";
  CachedPlace(&cache, "a.glb", kZUp, bytes).Keep(kCachedFromTriangles, block, load);
  EXPECT_EQ(cache.Usage().files, 2U);
}

TEST(SceneAxes, ZUpIsSuggestedWhereItWouldHelp) {
  constexpr const char* kLine = "lies beside the base, and would lie over it if the file's z axis were up";
  const auto warned = [&](const Model& model, const LoadOptions& options) {
    const Loaded loaded = LoadBytes(model.Bytes(), options);
    EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
    return loaded.Warnings().find(kLine) != std::string::npos;
  };
  EXPECT_TRUE(warned(TetraZUp(), kTouchAll));
  EXPECT_FALSE(warned(TetraZUp(), kZUp));
  EXPECT_FALSE(warned(Tetra(), kTouchAll));
  LoadOptions fit = kTouchAll;
  fit.fit = true;
  EXPECT_FALSE(warned(TetraZUp(), fit)) << "it is in reach either way";
  LoadOptions scaled = kTouchAll;
  scaled.scale = 1000;
  scaled.offset_base_m = {0.001, 0.002, 0};
  Model small = TetraZUp();
  small.json["nodes"][0]["scale"] = {0.001, 0.001, 0.001};
  EXPECT_TRUE(warned(small, scaled)) << "as it is placed";
  LoadOptions document = kTouchAll;
  const TempFolder folder;
  const int memory = open(folder.Write("document.glb", TetraZUp().Bytes()).c_str(), O_RDONLY | O_CLOEXEC);
  document.memory = memory;
  const Loaded loaded = Load("document", document);
  EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_EQ(loaded.Warnings().find(kLine), std::string::npos) << "its application places it";
  close(memory);
  Model far = TetraZUp();
  far.json["nodes"][0]["translation"] = {5, 5, 5};
  EXPECT_FALSE(warned(far, kTouchAll)) << "turning it would not help";
}

}  // namespace test_scene_axes
}  // namespace omni::scene::test
