// [XrEventDataReferenceSpaceChangePending] the base stays where it is in the world when an origin moves.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "layer/src/spaces/base_pose.h"
#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_recentre {

using layer::BasePose;
using layer::BasePoseHistory;
using layer::Pose;

constexpr float kMoved[7] = {0.4f, -0.1f, 0.7f, 0, 0.6f, 0, 0.8f};

class SpacesRecentre : public SpacesTest {
 protected:
  void Begin(App& app) {
    Start(app);
    stage = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
    service.SetTrajectory([](protocol::ToolSample& sample) { sample.position_base_m = {0.01, 0.02, 0.07}; });
    ForgetOldPath(app);
    ForgetOldPath(app);
    app.Poll();
  }
  // The pen in STAGE, which stays, at that time.
  Seen InStage(std::int64_t t_ns) {
    service.Fill();
    return Locate(pen, stage, t_ns);
  }
  XrSpace stage = XR_NULL_HANDLE;
};

TEST_F(SpacesRecentre, PenStaysInTheWorldWhenLocalMoves) {
  App app;
  Begin(app);
  const Seen before = InStage(Now_ns());
  const glm::dvec3 in_local = Locate(pen, local, Now_ns()).p();
  ASSERT_EQ(omni_test_recenter(kMoved, 0), 0);
  app.Poll();
  const Seen after = InStage(Now_ns());
  ASSERT_EQ(after.location.locationFlags, kSeen);
  EXPECT_LT(glm::length(after.p() - before.p()), 1e-5);
  EXPECT_LT(Angle(after.q(), before.q()), 1e-3);
  EXPECT_GT(glm::length(Locate(pen, local, Now_ns()).p() - in_local), 0.1) << "LOCAL is the one that moved";
}

TEST_F(SpacesRecentre, RepeatedRecentringKeepsPenInPlace) {
  App app;
  Begin(app);
  const Seen before = InStage(Now_ns());
  for (int i = 0; i < 20; ++i) {  // more than are remembered
    ASSERT_EQ(omni_test_recenter(kMoved, 0), 0);
    app.Poll();
  }
  EXPECT_LT(glm::length(InStage(Now_ns()).p() - before.p()), 1e-4);
}

// A change holds from changeTime on: until then, and for queries of earlier times, the origin is where it was.
TEST_F(SpacesRecentre, PendingChangeAppliesFromChangeTime) {
  App app;
  Begin(app);
  const std::int64_t asked = Now_ns();
  const Seen before = InStage(asked);
  ASSERT_EQ(omni_test_recenter(kMoved, 60'000'000), 0);
  app.Poll();
  for (const std::int64_t t : {asked, asked + 30'000'000, asked + 90'000'000, asked + 10'000'000'000}) {
    const Seen at = InStage(t);
    EXPECT_LT(glm::length(at.p() - before.p()), 1e-5) << "asked " << (t - asked) / 1'000'000 << " ms ahead";
  }
}

TEST_F(SpacesRecentre, ChangeOfAnotherSpaceIsIgnored) {
  App app;
  Begin(app);
  service.Fill();
  const glm::dvec3 in_local = Locate(pen, local, Now_ns()).p();
  ASSERT_EQ(omni_test_move_space("stage", kMoved, 0, 1), 0);
  app.Poll();
  service.Fill();
  EXPECT_LT(glm::length(Locate(pen, local, Now_ns()).p() - in_local), 1e-5);
}

// poseValid false: the base's pose is unknown. VALID stays, TRACKED is cleared, and it is logged once.
TEST_F(SpacesRecentre, UnknownChangeClearsTracked) {
  const std::string log = std::string(std::getenv("OMNI_SOCKET")) + ".log";
  std::filesystem::remove(log);
  setenv("OMNI_LAYER_LOG", log.c_str(), 1);
  {
    App app;
    unsetenv("OMNI_LAYER_LOG");
    Begin(app);
    ASSERT_EQ(omni_test_move_space("local", kMoved, 0, 0), 0);
    EXPECT_EQ(InStage(Now_ns()).location.locationFlags, kSeen) << "not polled yet";
    app.Poll();
    const Seen after = InStage(Now_ns());
    EXPECT_EQ(after.location.locationFlags, layer::kValid);
    EXPECT_EQ(after.velocity.velocityFlags, layer::kVelocityValid);
    for (int i = 0; i < 3; ++i) InStage(Now_ns());
  }
  std::ifstream file(log);
  int lines = 0;
  for (std::string line; std::getline(file, line);) lines += line.find("no longer tracked") != std::string::npos;
  EXPECT_EQ(lines, 1);
}

XrEventDataReferenceSpaceChangePending Change(XrReferenceSpaceType space, XrTime time, const Pose& pose,
                                              bool known = true) {
  return {XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING, nullptr,          XR_NULL_HANDLE, space, time,
          known ? XrBool32{XR_TRUE} : XrBool32{XR_FALSE},    layer::ToXr(pose)};
}

Pose RandomPose(std::mt19937& random) {
  std::uniform_real_distribution<> uniform(-2, 2);
  return {{uniform(random), uniform(random), uniform(random)},
          layer::ExpRotation({uniform(random), uniform(random), uniform(random)})};
}

// X_LL' X_L'O = X_LO through any number of changes.
TEST(BasePoseHistoryTest, BaseStaysInPlaceThroughRandomChanges) {
  std::mt19937 random(5);
  BasePoseHistory history;
  const Pose X_LO = RandomPose(random);
  history.Set({XR_REFERENCE_SPACE_TYPE_STAGE, X_LO, true, true}, 0);
  Pose X_WL;  // the first origin is the world's
  for (XrTime time = 100; time < 100 * 14; time += 100) {
    const Pose X_LLn = RandomPose(random);
    EXPECT_TRUE(history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_STAGE, time, X_LLn)));
    EXPECT_TRUE(history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_LOCAL, time, RandomPose(random)))) << "another's";
    const Pose before = layer::Compose(X_WL, history.At(time - 1).X_LO);
    X_WL = layer::Compose(X_WL, X_LLn);
    const Pose after = layer::Compose(X_WL, history.At(time).X_LO);
    EXPECT_LT(glm::length(before.p - X_LO.p), 1e-5);
    EXPECT_LT(glm::length(after.p - X_LO.p), 1e-5);
    EXPECT_LT(Angle(after.q, X_LO.q), 1e-5);
  }
}

// A base pose measured now applies to the present origin; a pending change still comes.
TEST(BasePoseHistoryTest, NewBasePoseKeepsPendingChanges) {
  std::mt19937 random(6);
  BasePoseHistory history;
  const Pose pending = RandomPose(random);
  history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_STAGE, 50, RandomPose(random)));
  history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_STAGE, 200, pending));
  const Pose X_LO = RandomPose(random);
  history.Set({XR_REFERENCE_SPACE_TYPE_STAGE, X_LO, true, true}, 100);
  EXPECT_EQ(history.At(100).space, XR_REFERENCE_SPACE_TYPE_STAGE);
  EXPECT_LT(glm::length(history.At(199).X_LO.p - X_LO.p), 1e-12);
  EXPECT_LT(glm::length(layer::Compose(pending, history.At(200).X_LO).p - X_LO.p), 1e-5);
  EXPECT_LT(glm::length(history.At(std::numeric_limits<XrTime>::min()).X_LO.p - X_LO.p), 1e-12);
}

TEST(BasePoseHistoryTest, NewBasePoseRestoresTrackingAfterUnknownMove) {
  BasePoseHistory history;
  EXPECT_TRUE(history.At(5).tracked);
  EXPECT_FALSE(history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_LOCAL, 10, {}, false)));
  EXPECT_TRUE(history.At(9).tracked);
  EXPECT_FALSE(history.At(10).tracked);
  EXPECT_TRUE(history.At(10).valid);
  EXPECT_TRUE(history.OnChange(Change(XR_REFERENCE_SPACE_TYPE_LOCAL, 20, {})));
  EXPECT_FALSE(history.At(20).tracked) << "a known move does not restore tracking";
  history.Set({}, 30);
  EXPECT_TRUE(history.At(30).tracked);
}

}  // namespace test_spaces_recentre
}  // namespace omni::test
