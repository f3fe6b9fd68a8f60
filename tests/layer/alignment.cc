// The base pose of the base: requested, used, guessed, and followed when the runtime moves a space.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>

#include "layer/src/spaces/locate.h"
#include "service/protocol/base_pose.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_alignment {

using layer::Pose;

constexpr XrSpaceLocationFlags kAll = layer::kValid | layer::kTracked;
const glm::dvec3 kPen_B(0.01, 0.02, 0.06);  // the fake pen rests there

protocol::BasePose KnownIn(std::int32_t space, const Pose& X_LB) {
  protocol::BasePose base_pose;
  base_pose.known = 1;
  base_pose.space = space;
  base_pose.base_space = {.position_m = {X_LB.p.x, X_LB.p.y, X_LB.p.z},
                          .orientation_wxyz = {X_LB.q.w, X_LB.q.x, X_LB.q.y, X_LB.q.z}};
  base_pose.expected_error_m = 1e-3;
  return base_pose;
}

const Pose kPlaced{{0.4, 0.8, -0.3}, glm::normalize(glm::dquat(0.6, -0.6, 0.3, 0.2))};

class Alignment : public testing::Test {
 protected:
  void SetUp() override {
    omni_test_reset();
    service = std::make_unique<FakeService>();
    Rest(*service);
  }
  static void Rest(FakeService& fake) {
    fake.SetTrajectory([](protocol::ToolSample& sample) { sample.position_base_m = {kPen_B.x, kPen_B.y, kPen_B.z}; });
  }
  void Start(App& app) {
    ASSERT_TRUE(app.WaitProfile(*service, kTouch));
    local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    stage = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
    pen = app.ActionSpace(app.pose, app.right);
  }
  XrSpaceLocation At(XrSpace base, std::int64_t after_ns = 0) {
    service->Fill();
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(pen, base, Now_ns() + after_ns + kRuntimeOffset_ns, &location), XR_SUCCESS);
    return location;
  }
  double DistanceFrom(const glm::dvec3& p, XrSpace base, std::int64_t after_ns = 0) {
    return glm::length(layer::FromXr(At(base, after_ns).pose.position) - p);
  }
  // Polls the socket until the pen is there.
  bool Comes(App& app, const glm::dvec3& p, XrSpace base) {
    return app.SyncUntil(*service, [&] { return DistanceFrom(p, base) < 1e-5; });
  }

  std::unique_ptr<FakeService> service;
  XrSpace local = XR_NULL_HANDLE, stage = XR_NULL_HANDLE, pen = XR_NULL_HANDLE;
};

TEST_F(Alignment, RequestsBasePoseForRuntimeSystemAndSpaces) {
  App app;
  Start(app);
  const Heard heard = service->heard();
  ASSERT_EQ(heard.base_pose_requests.size(), 1U);
  const protocol::BasePoseRequest& request = heard.base_pose_requests.front();
  XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES};
  ASSERT_EQ(xrGetInstanceProperties(app.instance, &properties), XR_SUCCESS);
  EXPECT_STREQ(request.headset.runtime, properties.runtimeName);
  EXPECT_STREQ(request.headset.system, "Omni test system");
  ASSERT_GE(request.space_count, 2U);
  EXPECT_EQ(request.spaces[0], protocol::kSpaceStage) << "the most stable space first";
  EXPECT_EQ(request.spaces[request.space_count - 1], protocol::kSpaceLocal);
}

TEST_F(Alignment, MeasuredBasePoseLocatesPenInItsSpace) {
  service->SetBasePose(KnownIn(protocol::kSpaceStage, kPlaced));
  App app;
  Start(app);
  const glm::dvec3 in_stage = kPlaced.p + kPlaced.q * kPen_B;
  EXPECT_LT(DistanceFrom(in_stage, stage), 1e-5) << "from the first pose on: it does not jump";
  EXPECT_EQ(At(stage).locationFlags, kAll);
  EXPECT_LT(DistanceFrom(in_stage - glm::dvec3(0, 1.6, 0), local), 1e-5) << "LOCAL is 1.6 m above STAGE";
}

TEST_F(Alignment, NewBasePoseMovesPenInRunningSession) {
  App app;
  Start(app);
  Pose moved = kPlaced;
  moved.p += glm::dvec3(0.1, 0, 0);
  for (const Pose& X : {kPlaced, moved}) {
    service->SetBasePose(KnownIn(protocol::kSpaceStage, X));
    EXPECT_TRUE(Comes(app, X.p + X.q * kPen_B, stage));
  }
  service->SetBasePose(KnownIn(protocol::kSpaceLocal, kPlaced));
  EXPECT_TRUE(Comes(app, kPlaced.p + kPlaced.q * kPen_B, local)) << "a base pose in another space";
}

// The pen is tracked, about a base whose place is a guess; if the user disabled guessing, there is no pose.
TEST_F(Alignment, UnknownBasePoseIsGuessedInFrontOfTheUser) {
  protocol::BasePose unknown;
  service->SetBasePose(unknown);
  App app;
  Start(app);
  const Pose guess = layer::DefaultBasePose();
  EXPECT_LT(DistanceFrom(guess.p + guess.q * kPen_B, local), 1e-5);
  EXPECT_TRUE(app.SyncUntil(*service, [&] { return At(local).locationFlags == kAll; }))
      << "an engine that waits for a controller's first tracked pose shows it";
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));

  unknown.uncalibrated = protocol::Uncalibrated::kCalibrated;
  service->SetBasePose(unknown);
  EXPECT_TRUE(app.SyncUntil(*service, [&] { return At(local).locationFlags == 0; }));
  EXPECT_TRUE(app.PoseActive(app.pose, app.right)) << "the pen is present, only its place is unknown";

  service->SetBasePose(KnownIn(protocol::kSpaceLocal, kPlaced));
  EXPECT_TRUE(app.SyncUntil(*service, [&] { return At(local).locationFlags == kAll; }));
  protocol::BasePose off = KnownIn(protocol::kSpaceLocal, kPlaced);
  off.uncalibrated = protocol::Uncalibrated::kOff;
  service->SetBasePose(off);
  EXPECT_TRUE(app.SyncUntil(*service, [&] { return At(local).locationFlags == 0; }));
}

TEST_F(Alignment, DoubtfulBasePoseIsNotTracked) {
  protocol::BasePose doubtful = KnownIn(protocol::kSpaceStage, kPlaced);
  doubtful.doubtful = 1;
  service->SetBasePose(doubtful);
  App app;
  Start(app);
  EXPECT_LT(DistanceFrom(kPlaced.p + kPlaced.q * kPen_B, stage), 1e-5);
  EXPECT_EQ(At(stage).locationFlags, layer::kValid);
}

// [XrEventDataReferenceSpaceChangePending] Recentring LOCAL must not move the pen in the world, at once or afterwards,
// and the service is notified.
TEST_F(Alignment, RecentringKeepsPenInPlaceAndIsReportedToService) {
  service->SetBasePose(KnownIn(protocol::kSpaceLocal, kPlaced));
  App app;
  Start(app);
  const glm::dvec3 in_local = kPlaced.p + kPlaced.q * kPen_B;
  ASSERT_LT(DistanceFrom(in_local, local), 1e-5);
  const glm::dvec3 in_stage = layer::FromXr(At(stage).pose.position);

  const float recentred[7] = {0.3f, -0.1f, 0.2f, 0, 0.6f, 0, 0.8f};
  constexpr std::int64_t kDelay_ns = 200'000'000;
  const std::int64_t before_ns = Now_ns();
  ASSERT_EQ(omni_test_recenter(recentred, kDelay_ns), 0);
  app.Poll();
  EXPECT_LT(DistanceFrom(in_stage, stage), 1e-5) << "before the change";
  EXPECT_LT(DistanceFrom(in_stage, stage, 2 * kDelay_ns), 1e-5) << "a query for a time after it";
  ASSERT_TRUE(app.SyncUntil(*service, [&] { return !service->heard().space_changes.empty(); }));
  const protocol::SpaceChange reported = service->heard().space_changes.front();
  EXPECT_EQ(reported.space, protocol::kSpaceLocal);
  EXPECT_EQ(reported.pose_valid, 1U);
  EXPECT_NEAR(reported.new_in_previous.position_m[0], 0.3, 1e-6);
  EXPECT_NEAR(reported.new_in_previous.orientation_wxyz[0], 0.8, 1e-6);
  EXPECT_GE(reported.changes_at_ns, before_ns + kDelay_ns) << "CLOCK_MONOTONIC, not the runtime's clock";
  EXPECT_LT(reported.changes_at_ns, Now_ns() + kDelay_ns);

  ASSERT_TRUE(app.SyncUntil(*service, [&] { return Now_ns() > before_ns + kDelay_ns + 20'000'000; }));
  EXPECT_LT(DistanceFrom(in_stage, stage), 1e-5) << "after the change";
  EXPECT_GT(DistanceFrom(in_local, local), 0.1) << "LOCAL itself has moved";

  // The service sends what its file holds now: the change is in it, and must not be applied twice.
  const Pose P = layer::FromXr(XrPosef{{0, 0.6f, 0, 0.8f}, {0.3f, -0.1f, 0.2f}});
  protocol::BasePose after = KnownIn(protocol::kSpaceLocal, layer::Compose(layer::Inverse(P), kPlaced));
  after.changes_until_ns = reported.changes_at_ns;
  after.rotation_sigma_rad = 0.01;
  service->SetBasePose(after);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(app.SyncUntil(*service, [] { return true; }));
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
    ASSERT_LT(DistanceFrom(in_stage, stage), 1e-5) << i;
  }
}

// A runtime that moves an origin by 250 m: the new origin counts as unknown, for the service too.
TEST_F(Alignment, OutOfRangeRecentringClearsTracked) {
  service->SetBasePose(KnownIn(protocol::kSpaceLocal, kPlaced));
  App app;
  Start(app);
  ASSERT_LT(DistanceFrom(kPlaced.p + kPlaced.q * kPen_B, local), 1e-5);
  const float recentred[7] = {250, 0, 0, 0, 0, 0, 1};
  ASSERT_EQ(omni_test_recenter(recentred, 0), 0);
  app.Poll();
  EXPECT_EQ(At(local).locationFlags, layer::kValid);
  EXPECT_LT(DistanceFrom(kPlaced.p + kPlaced.q * kPen_B, local), 1e-5);
  ASSERT_TRUE(
      app.SyncUntil(*service, [&] { return service->heard().gone > 0 || !service->heard().space_changes.empty(); }));
  const Heard heard = service->heard();
  EXPECT_EQ(heard.gone, 0) << "a message out of range would end the connection";
  ASSERT_EQ(heard.space_changes.size(), 1U);
  EXPECT_EQ(heard.space_changes.front().pose_valid, 0U);
}

// Another application was faster: the base pose that we get has the change already, our own event comes later.
TEST_F(Alignment, RecentringAlreadyInBasePoseIsNotAppliedTwice) {
  App app;
  Start(app);
  protocol::BasePose after = KnownIn(protocol::kSpaceLocal, kPlaced);
  after.changes_until_ns = Now_ns() + 50'000'000;
  service->SetBasePose(after);
  ASSERT_TRUE(Comes(app, kPlaced.p + kPlaced.q * kPen_B, local));
  const float recentred[7] = {0.3f, -0.1f, 0.2f, 0, 0, 0, 1};
  ASSERT_EQ(omni_test_recenter(recentred, 0), 0);
  app.Poll();
  EXPECT_LT(DistanceFrom(kPlaced.p + kPlaced.q * kPen_B, local), 1e-5);
  EXPECT_TRUE(service->heard().space_changes.empty());
}

TEST_F(Alignment, RequestsBasePoseAgainFromNewService) {
  App app;
  Start(app);
  service.reset();
  service = std::make_unique<FakeService>();
  Rest(*service);
  service->SetBasePose(KnownIn(protocol::kSpaceStage, kPlaced));
  EXPECT_TRUE(Comes(app, kPlaced.p + kPlaced.q * kPen_B, stage));
  EXPECT_EQ(service->heard().base_pose_requests.size(), 1U);
}

}  // namespace test_alignment
}  // namespace omni::test
