// A load can be ended while it reads, decodes, repairs, orients, indexes and lays out: it asks often, and leaves
// nothing behind.
#include <gtest/gtest.h>

#include "service/base/work_watch.h"
#include "service/scene/load_scene.h"
#include "tests/scene/files.h"
#include "tests/support/mesh_bombs.h"

namespace omni::scene::test {
namespace test_scene_cancel {

using base::WorkWatch;
using omni::test::MeshBomb;

constexpr std::size_t kTriangles = 20'000;
constexpr std::uint64_t kMostBetweenQuestions = 10'000;  // units of less than a microsecond

base::Result<haptics::Scene> LoadWith(const std::string& path, CacheStore* cache, const WorkWatch& watch) {
  LoadReport load;
  haptics::BuildReport build;
  return LoadScene(path, {.watch = &watch}, cache, load, build);
}

template <class Check>
void ForEachMesh(Check check) {
  const TempFolder folder;
  check(omni::test::kCleanMesh,
        folder.Write("mesh.glb", omni::test::MeshFile(omni::test::kCleanMesh.make(kTriangles))));
  for (const MeshBomb& bomb : omni::test::kMeshBombs)
    check(bomb, folder.Write("mesh.glb", omni::test::MeshFile(bomb.make(kTriangles))));
}

TEST(CancelLoad, AsksOften) {
  ForEachMesh([](const MeshBomb& bomb, const std::string& path) {
    const WorkWatch watch;
    const auto scene = LoadWith(path, nullptr, watch);
    ASSERT_TRUE(scene.ok()) << scene.error();
    EXPECT_LE(watch.longest(), kMostBetweenQuestions) << bomb.name;
    EXPECT_GE(watch.done(), 3 * kTriangles) << bomb.name;
    // Work that is not counted cannot be ended: every phase counts.
    EXPECT_GE(watch.done(), 15 * std::uint64_t{scene->header().triangle_count}) << bomb.name;
  });
}

TEST(CancelLoad, EndsAtAnyQuestionAndLeavesNothing) {
  ForEachMesh([](const MeshBomb& bomb, const std::string& path) {
    std::uint64_t questions = 0;
    const WorkWatch counting([&] { return ++questions == 0; });
    ASSERT_TRUE(LoadWith(path, nullptr, counting).ok());
    const TempFolder folder;
    CacheStore cache(folder.Path("cache"));
    for (const double share : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0}) {
      const auto last = static_cast<std::uint64_t>(share * static_cast<double>(questions - 1));
      std::uint64_t asked = 0;
      const WorkWatch watch([&] { return asked++ >= last; });
      const auto scene = LoadWith(path, &cache, watch);
      ASSERT_FALSE(scene.ok()) << bomb.name << " " << share;
      EXPECT_EQ(scene.error(), "cancelled") << bomb.name;
      EXPECT_EQ(asked, last + 1) << bomb.name << ": worked on after it was to end";
      EXPECT_EQ(cache.Usage().files, 0U) << bomb.name << " " << share;
    }
  });
}

TEST(CancelLoad, AWatchThatNeverEndsChangesNothing) {
  const TempFolder folder;
  const std::string path = folder.Write("mesh.glb", omni::test::MeshFile(omni::test::meshes::Ship(5000)));
  const WorkWatch watch([] { return false; });
  LoadReport load;
  haptics::BuildReport build;
  const auto a = LoadWith(path, nullptr, watch), b = LoadScene(path, {}, nullptr, load, build);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(std::equal(a->block().begin(), a->block().end(), b->block().begin(), b->block().end()));
}

}  // namespace test_scene_cancel
}  // namespace omni::scene::test
