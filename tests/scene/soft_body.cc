// Soft bodies through the cache: computed once, then read back identically.
#include <gtest/gtest.h>

#include <filesystem>

#include "service/haptics/live/make_live.h"
#include "service/scene/load_scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/temp_folder.h"

namespace omni::scene {
namespace test_scene_soft_body {

namespace fs = std::filesystem;

haptics::Mesh Ball(double radius_m = 0.02) {
  haptics::Material jelly;
  jelly.softness.model = haptics::SoftnessModel::kTet;
  return haptics::MeshOf(haptics::Built(haptics::SceneOf(haptics::Sphere(8, radius_m), jelly)), 0);
}

haptics::SoftBodyOptions Coarse() {
  haptics::SoftBodyOptions options;
  options.lattice.max_tets = 200;
  return options;
}

bool Equal(const haptics::SoftBody& a, const haptics::SoftBody& b) {
  return std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin(), b.bytes().end());
}

TEST(SoftBodyCache, SecondLoadIsReadFromTheCache) {
  const test::TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  SoftLoadReport first, second, other;
  const auto built = LoadSoftBody(Ball(), Coarse(), &cache, first);
  ASSERT_TRUE(built.ok()) << built.error();
  EXPECT_FALSE(first.cached);
  EXPECT_GT(first.build.tets, 0U);
  EXPECT_EQ(cache.Usage().files, 1U);
  const auto read = LoadSoftBody(Ball(), Coarse(), &cache, second);
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(second.cached) << second.cache;
  EXPECT_TRUE(Equal(*built, *read));
  EXPECT_EQ(second.build.surface_nodes, first.build.surface_nodes);
  // Anything that changes the body changes the key.
  haptics::SoftBodyOptions softer = Coarse();
  softer.moduli.young_modulus_Pa *= 0.5;
  ASSERT_TRUE(LoadSoftBody(Ball(), softer, &cache, other).ok());
  EXPECT_FALSE(other.cached);
  ASSERT_TRUE(LoadSoftBody(Ball(0.021), Coarse(), &cache, other).ok());
  EXPECT_FALSE(other.cached);
  EXPECT_EQ(cache.Usage().files, 3U);
}

TEST(SoftBodyCache, DamagedEntryIsRebuilt) {
  const test::TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  SoftLoadReport report;
  const auto built = LoadSoftBody(Ball(), Coarse(), &cache, report);
  ASSERT_TRUE(built.ok());
  const std::string file = fs::directory_iterator(cache.folder())->path().string();
  fs::resize_file(file, fs::file_size(file) / 2);
  const auto again = LoadSoftBody(Ball(), Coarse(), &cache, report);
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(report.cached);
  EXPECT_NE(report.cache.find("rebuilt"), std::string::npos) << report.cache;
  EXPECT_TRUE(Equal(*built, *again)) << "and it is the same";
  ASSERT_TRUE(LoadSoftBody(Ball(), Coarse(), &cache, report).ok());
  EXPECT_TRUE(report.cached) << "kept again";
}

TEST(SoftBodyCache, CancelledBuildLeavesNoEntry) {
  const test::TempFolder folder;
  CacheStore cache(folder.Path("omni"));
  SoftLoadReport report;
  for (int allowed = 0; allowed < 6; ++allowed) {
    haptics::SoftBodyOptions options = Coarse();
    options.progress = [left = allowed](double) mutable { return left-- > 0; };
    const auto body = LoadSoftBody(Ball(), options, &cache, report);
    ASSERT_FALSE(body.ok());
    EXPECT_NE(body.error().find("cancelled"), std::string::npos);
    EXPECT_EQ(cache.Usage().files, 0U);
  }
  ASSERT_TRUE(LoadSoftBody(Ball(), Coarse(), &cache, report).ok()) << "done again next time";
}

TEST(SoftBodyCache, WorksWithoutACache) {
  SoftLoadReport report;
  EXPECT_TRUE(LoadSoftBody(Ball(), Coarse(), nullptr, report).ok());
  CacheStore off("/proc/no/cache");
  EXPECT_TRUE(LoadSoftBody(Ball(), Coarse(), &off, report).ok());
  EXPECT_NE(report.cache.find("off"), std::string::npos);
  haptics::Mesh sheet = Ball();
  for (haptics::Vec3& v : sheet.vertices) v.z = 0;
  const auto none = LoadSoftBody(sheet, Coarse(), nullptr, report);
  ASSERT_FALSE(none.ok());
  EXPECT_NE(none.error().find("inside"), std::string::npos) << none.error();
}

}  // namespace test_scene_soft_body
}  // namespace omni::scene
