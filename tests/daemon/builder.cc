// Scenes first, their soft bodies after: delivered, cached, cancelled, and never delaying another scene.
#include <gtest/gtest.h>

#include "service/daemon/scenes/scene_builder.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "tests/builder/scene_builder_test.h"
#include "tests/haptics/scenario.h"

namespace omni::daemon {
namespace test_daemon_builder {

constexpr std::uint32_t kCoarse = 150;    // a tenth of a second
constexpr std::uint32_t kForever = 4000;  // more than a test waits for

class BuilderTest : public SceneBuilderTest {
 protected:
  std::uint64_t Kept() const { return scene::CacheStore(folder_.Path("cache")).Usage().files; }
};

TEST_F(BuilderTest, ASceneWithoutTagsHasNoLiveParts) {
  SceneBuilder builder(0.0375);
  builder.Request(1, Rigid("rigid"));
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  EXPECT_EQ(built.scene->live(), nullptr);
  EXPECT_EQ(builder.Progress(1).objects, 0U);
}

TEST_F(BuilderTest, DeliversTheSceneBeforeItsSoftBodies) {
  SceneBuilder builder(0.0375, {}, kCoarse);
  builder.Request(1, Soft("two", 2));
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  ASSERT_NE(built.scene->live(), nullptr);
  EXPECT_EQ(builder.Progress(1).objects, 2U);
  for (std::uint32_t k = 0; k < 2; ++k) {
    const SoftOutcome soft = Outcome(builder);
    EXPECT_EQ(soft.error, "");
    EXPECT_EQ(soft.client, 1U);
    EXPECT_EQ(soft.object, "ball " + std::to_string(k));
    const haptics::SoftBody* body = built.scene->live()->soft_body(k);
    ASSERT_NE(body, nullptr);
    EXPECT_EQ(body->view().header().node_count, soft.report.build.surface_nodes);
  }
  const SoftProgress progress = builder.Progress(1);
  EXPECT_EQ(progress.ready, 2U);
  EXPECT_EQ(progress.failed, 0U);
  EXPECT_EQ(progress.done, 1);
}

TEST_F(BuilderTest, CachesSoftBodies) {
  const config::AppEntry app = Soft("kept", 1);
  for (const bool cached : {false, true}) {
    SceneBuilder builder(0.0375, folder_.Path("cache"), kCoarse);
    builder.Request(1, app);
    ASSERT_NE(Result(builder).scene, nullptr);
    EXPECT_EQ(Outcome(builder).report.cached, cached);
    EXPECT_EQ(Kept(), 1U);
  }
}

TEST_F(BuilderTest, RequestedScenesPreemptSoftBodies) {
  SceneBuilder builder(0.0375, folder_.Path("cache"), kForever);
  builder.Request(1, Soft("slow", 1));
  ASSERT_EQ(Result(builder).client, 1U);
  ASSERT_TRUE(Soon([&] { return builder.Progress(1).done > 0; })) << "it has started";
  for (std::uint64_t client = 2; client < 5; ++client) {
    builder.Request(client, Rigid("rigid"));
    EXPECT_EQ(Result(builder).client, client);
    EXPECT_EQ(builder.Progress(1).ready, 0U);
  }
  const double before = builder.Progress(1).done;
  EXPECT_GT(before, 0) << "and nothing was lost";
  EXPECT_TRUE(Soon([&] { return builder.Progress(1).done > before; })) << "it goes on";
  EXPECT_FALSE(builder.PopSoftOutcome());
}

TEST_F(BuilderTest, CancelStopsTheJobAndDiscardsItsResults) {
  SceneBuilder builder(0.0375, folder_.Path("cache"), kForever);
  builder.Request(1, Soft("slow", 3));
  std::weak_ptr<const haptics::Scene> scene;
  {
    const BuiltScene built = Result(builder);
    ASSERT_TRUE(Soon([&] { return builder.Progress(1).done > 0; }));
    scene = built.scene;
  }
  EXPECT_FALSE(scene.expired()) << "the builder holds it while it works";
  builder.Cancel(1);
  EXPECT_EQ(builder.Progress(1).objects, 0U);
  EXPECT_TRUE(Soon([&] { return scene.expired(); })) << "it is cancelled";
  EXPECT_EQ(Kept(), 0U);
  EXPECT_FALSE(builder.PopSoftOutcome());
  builder.Request(1, Rigid("rigid"));
  EXPECT_NE(Result(builder).scene, nullptr) << "and it builds later requests";
}

TEST_F(BuilderTest, NewRequestReplacesTheClientsOldOne) {
  SceneBuilder builder(0.0375, {}, kForever);
  builder.Request(1, Soft("slow", 2));
  ASSERT_NE(Result(builder).scene, nullptr);
  ASSERT_TRUE(Soon([&] { return builder.Progress(1).done > 0; }));
  builder.Request(1, Rigid("rigid"));
  EXPECT_EQ(Result(builder).scene->live(), nullptr);
  EXPECT_EQ(builder.Progress(1).objects, 0U);
}

TEST_F(BuilderTest, DestructorStopsARunningJob) {
  {
    SceneBuilder builder(0.0375, folder_.Path("cache"), kForever);
    builder.Request(1, Soft("slow", 1));
    ASSERT_NE(Result(builder).scene, nullptr);
    ASSERT_TRUE(Soon([&] { return builder.Progress(1).done > 0; }));
  }
  EXPECT_EQ(Kept(), 0U);
}

TEST_F(BuilderTest, FailedSoftBodyIsReportedAndTheNextIsBuilt) {
  haptics::Material jelly;
  jelly.softness.model = haptics::SoftnessModel::kTet;
  haptics::SceneInput input = haptics::SceneOf(haptics::Block(6, {0.02, 0.02, 0.02}), jelly);
  input.objects[0].triangles.resize(input.objects[0].triangles.size() / 6);  // a sheet: nothing is inside
  input.objects[0].triangle_material.resize(input.objects[0].triangles.size());
  input.objects[0].name = "sheet";
  input.objects.push_back(haptics::Sphere(8, 0.02));
  for (base::Vec3& v : input.objects[1].vertices_base_m) v.x += 0.05;
  SceneBuilder builder(0.0375, {}, kCoarse);
  builder.Request(7, Saved("sheet", input));
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  const SoftOutcome sheet = Outcome(builder);
  EXPECT_EQ(sheet.object, "sheet");
  EXPECT_NE(sheet.error.find("inside"), std::string::npos) << sheet.error;
  EXPECT_EQ(Outcome(builder).error, "");
  EXPECT_EQ(built.scene->live()->soft_body(0), nullptr) << "stays a layer";
  EXPECT_NE(built.scene->live()->soft_body(1), nullptr);
  EXPECT_EQ(builder.Progress(7).failed, 1U);
  EXPECT_EQ(builder.Progress(7).done, 1);
}

TEST_F(BuilderTest, SculptableObjectGetsASculptSessionOrAWarning) {
  haptics::Material clay;
  clay.sculpt.enabled = true;
  haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(6, 0.02), clay);
  SceneBuilder builder(0.0375);
  builder.Request(1, Saved("clay", input));
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr);
  ASSERT_NE(built.scene->live(), nullptr);
  EXPECT_EQ(built.scene->live()->sculpt_session_count(), 1U);
  EXPECT_TRUE(built.warnings.empty());
  input.objects[0].triangles.resize(input.objects[0].triangles.size() / 6);
  input.objects[0].triangle_material.resize(input.objects[0].triangles.size());
  builder.Request(1, Saved("open", input));
  const BuiltScene open = Result(builder);
  ASSERT_NE(open.scene, nullptr);
  EXPECT_EQ(open.scene->live(), nullptr);
  ASSERT_EQ(open.warnings.size(), 1U);
  EXPECT_NE(open.warnings[0].find("not closed"), std::string::npos) << open.warnings[0];
}

}  // namespace test_daemon_builder
}  // namespace omni::daemon
