// Where the pen is, against motion known in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <thread>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces {

using layer::Motion;
using Spaces = SpacesTest;

// [xrLocateSpace] the past: best historical data.
TEST_F(Spaces, PastPosesAreInterpolatedWithin2um) {
  App app;
  Start(app);
  service.Fill();
  const std::int64_t now = Now_ns();
  for (std::int64_t back = 5'300'000; back < 100'000'000; back += 5'300'000) {
    const Seen seen = Locate(pen, local, now - back);
    ASSERT_EQ(seen.result, XR_SUCCESS);
    ASSERT_EQ(seen.location.locationFlags, kSeen);
    ASSERT_EQ(seen.velocity.velocityFlags, layer::kVelocityValid);
    const Motion truth = InLocal(Lissajous(1e-9 * static_cast<double>(now - back)));
    EXPECT_LT(glm::length(seen.p() - truth.X.p), 1e-4 * 0.02) << "float, and Hermite over 1 ms";
    EXPECT_LT(Angle(seen.q(), truth.X.q), 1e-3);
    EXPECT_LT(glm::length(seen.v() - truth.v), 1e-3 * glm::length(truth.v));
    EXPECT_LT(glm::length(seen.w() - truth.w), 1e-5 * glm::length(truth.w));
  }
}

// [fundamentals-prediction-time-limits] any future time is valid; the pose is carried on for at most 40 ms.
TEST_F(Spaces, FutureIsPredictedThenHeld) {
  App app;
  Start(app);
  service.Fill();
  const std::int64_t now = Now_ns();
  const Seen at_15ms = Locate(pen, local, now + 15'000'000);
  const Motion truth = InLocal(Lissajous(1e-9 * static_cast<double>(now + 15'000'000)));
  ASSERT_EQ(at_15ms.location.locationFlags, kSeen);
  // Constant velocity: half the acceleration times t^2 (plus one sample period).
  EXPECT_LT(glm::length(at_15ms.p() - truth.X.p), 0.5 * 0.02 * 12.6 * 12.6 * 2.3 * 0.017 * 0.017);
  EXPECT_GT(glm::length(at_15ms.p() - Locate(pen, local, now - 1'000'000).p()), 1e-3) << "not merely held";
  const Seen far = Locate(pen, local, now + 100'000'000);
  const Seen further = Locate(pen, local, now + 3'600'000'000'000);
  ASSERT_EQ(far.location.locationFlags, kSeen);
  EXPECT_LT(glm::length(far.p() - further.p()), 1e-6);
  EXPECT_LT(glm::length(far.p() - at_15ms.p()), 0.3 * 0.04 * 1.2) << "at most 40 ms of motion";
}

// [xrLocateSpace] linearVelocity is that of the space's origin: offset times angular velocity added.
TEST_F(Spaces, VelocityOfOffsetSpaceIncludesLeverArm) {
  App app;
  Start(app);
  const glm::dvec3 offset(0.1, -0.2, 0.3);
  const XrSpace far = app.ActionSpace(app.pose, app.right, {{0, 0, 0, 1}, {0.1f, -0.2f, 0.3f}});
  service.Fill();
  const std::int64_t t = Now_ns() - 20'000'000;
  const Seen seen = Locate(far, local, t);
  const Motion truth = InLocal(WithOffset(offset, Lissajous(1e-9 * static_cast<double>(t))));
  EXPECT_LT(glm::length(seen.p() - truth.X.p), 1e-4);
  EXPECT_LT(glm::length(seen.v() - truth.v), 2e-3 * glm::length(truth.v));
  const Motion tip = InLocal(Lissajous(1e-9 * static_cast<double>(t)));
  EXPECT_GT(glm::length(seen.v() - tip.v), 0.1) << "the tip's velocity would be wrong";
}

// [xrLocateSpace] velocity is finite-difference consistent in a base that moves itself (the head).
TEST_F(Spaces, VelocityIsRelativeToMovingBase) {
  App app;
  Start(app);
  const float head[7] = {0.1f, 1.6f, 0.2f, 0, 0, 0, 1};
  const float head_velocity[6] = {0.3f, 0, -0.2f, 0, 1.5f, 0};
  omni_test_set_head(head, head_velocity);
  const XrSpace view = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  ForgetOldPath(app);
  service.Fill();
  const std::int64_t t = Now_ns() - 20'000'000;
  constexpr std::int64_t kStep = 2'000'000;
  const Seen before = Locate(pen, view, t - kStep);
  const Seen at = Locate(pen, view, t);
  const Seen after = Locate(pen, view, t + kStep);
  ASSERT_EQ(at.velocity.velocityFlags, layer::kVelocityValid);
  const glm::dvec3 difference = (after.p() - before.p()) / (2e-9 * static_cast<double>(kStep));
  EXPECT_LT(glm::length(at.v() - difference), 0.01 * glm::length(difference) + 2e-3);
  EXPECT_GT(glm::length(at.v() - InLocal(Lissajous(1e-9 * static_cast<double>(t))).v), 0.1) << "the base's part counts";
}

// A space of the runtime in a base that is the pen: the inverse, with velocity.
TEST_F(Spaces, LocatingInPenSpaceIsTheInverse) {
  App app;
  Start(app);
  service.Fill();
  const std::int64_t t = Now_ns() - 20'000'000;
  const Seen direct = Locate(pen, local, t);
  const Seen inverse = Locate(local, pen, t);
  ASSERT_EQ(inverse.location.locationFlags, kSeen);
  const Motion truth = layer::Inverse(InLocal(Lissajous(1e-9 * static_cast<double>(t))));
  EXPECT_LT(glm::length(inverse.p() - truth.X.p), 1e-4);
  EXPECT_LT(Angle(inverse.q(), glm::conjugate(direct.q())), 1e-3);
  EXPECT_LT(glm::length(inverse.v() - truth.v), 2e-3 * glm::length(truth.v));
  EXPECT_LT(glm::length(inverse.w() - truth.w), 1e-4 * glm::length(truth.w));
}

// [xrLocateSpace] two spaces of one entity: a rigid offset, valid and tracked even while it is not seen.
TEST_F(Spaces, TwoPenSpacesAreRigidlyJoined) {
  App app;
  Start(app);
  const XrSpace offset = app.ActionSpace(app.pose, app.right, {{0, 0, 0, 1}, {0, 0, -0.1f}});
  service.SetFlags(0);
  service.Fill();
  const Seen seen = Locate(offset, pen, Now_ns());
  EXPECT_EQ(seen.location.locationFlags, kSeen);
  EXPECT_LT(glm::length(seen.p() - glm::dvec3(0, 0, -0.1)), 1e-6);
  EXPECT_EQ(seen.velocity.velocityFlags, layer::kVelocityValid);
  EXPECT_LT(glm::length(seen.v()) + glm::length(seen.w()), 1e-9);
}

// [xrLocateSpace] errors are the runtime's.
TEST_F(Spaces, InvalidTimesHandlesAndStructuresAreRejected) {
  App app;
  Start(app);
  service.Fill();
  const std::int64_t now = Now_ns();
  EXPECT_EQ(Locate(pen, local, -kRuntimeOffset_ns).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Locate(local, pen, -kRuntimeOffset_ns).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Locate(pen, pen, -kRuntimeOffset_ns - 1).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Locate(pen, XR_NULL_HANDLE, now).result, XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Locate(XR_NULL_HANDLE, pen, now).result, XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(xrLocateSpace(pen, local, now + kRuntimeOffset_ns, nullptr), XR_ERROR_VALIDATION_FAILURE);
  XrSpaceLocation wrong{XR_TYPE_SPACE_VELOCITY};
  EXPECT_EQ(xrLocateSpace(pen, local, now + kRuntimeOffset_ns, &wrong), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(xrDestroySpace(pen), XR_SUCCESS);
  EXPECT_EQ(Locate(pen, local, now).result, XR_ERROR_HANDLE_INVALID);
}

// [xrLocateSpace] both spaces must be of one session.
TEST_F(Spaces, SpacesOfDifferentSessionsAreRejected) {
  App app;
  Start(app);
  const XrSession first = app.session;
  const XrSessionCreateInfo create{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, app.system};
  ASSERT_EQ(xrCreateSession(app.instance, &create, &app.session), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  app.state = XR_SESSION_STATE_UNKNOWN;
  app.PollUntilFocused();
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace other_pen = app.ActionSpace(app.pose, app.right);
  const XrSpace other_local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  service.Fill();
  EXPECT_EQ(Locate(pen, other_local, Now_ns()).result, XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Locate(other_local, pen, Now_ns()).result, XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Locate(pen, other_pen, Now_ns()).result, XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
  EXPECT_EQ(Locate(other_pen, other_local, Now_ns()).location.locationFlags, kSeen);
  EXPECT_EQ(xrDestroySession(app.session), XR_SUCCESS);
  app.session = first;
}

// [spaces-action-spaces-lifetime] not locatable unless the set was active in the last sync.
TEST_F(Spaces, LocatableOnlyWhileItsSetIsActive) {
  App app;
  Start(app);
  service.Fill();
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
  ASSERT_EQ(app.SyncSets({{app.set, app.left}}), XR_SUCCESS);
  service.Fill();
  const Seen off = Locate(pen, local, Now_ns());
  EXPECT_EQ(off.location.locationFlags, 0u);
  EXPECT_EQ(off.velocity.velocityFlags, 0u);
  ASSERT_EQ(app.SyncSets({{app.set, app.right}}), XR_SUCCESS);
  service.Fill();
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
  omni_test_set_focus(0);
  ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
  service.Fill();
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, 0u);
}

// Tracking lost: the pose stays valid, TRACKED goes. Never seen: not valid.
TEST_F(Spaces, TrackedAndValidFollowTheTracker) {
  App app;
  Start(app);
  const auto flags_after = [&](std::uint32_t tool_flags) {
    service.SetFlags(tool_flags);
    service.Fill();
    return Locate(pen, local, Now_ns()).location.locationFlags;
  };
  EXPECT_EQ(flags_after(protocol::kToolPoseValid), layer::kValid);
  EXPECT_EQ(flags_after(protocol::kToolPoseValid | protocol::kToolTracked), kSeen);
  EXPECT_EQ(flags_after(0), 0u);
}

// Service dead: the space loses VALID at once, without a sync; the action stays active until the next one.
TEST_F(Spaces, StalePenIsInvalidWithoutASync) {
  App app;
  Start(app);
  service.Fill();
  ASSERT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
  const timespec pause{0, 130'000'000};
  nanosleep(&pause, nullptr);
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, 0u);
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));
  service.Fill();
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
  nanosleep(&pause, nullptr);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FALSE(app.PoseActive(app.pose, app.right)) << "the connection is up, but no sample comes";
}

// [spaces-action-spaces-lifetime] a space works on after xrDestroyAction.
TEST_F(Spaces, SpaceOutlivesItsAction) {
  App app;
  Start(app);
  ASSERT_EQ(xrDestroyAction(app.pose), XR_SUCCESS);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(Locate(pen, local, Now_ns()).location.locationFlags, kSeen);
}

// [input-multiple] the XR_NULL_PATH space stays with the first device, even when that goes off.
TEST_F(Spaces, NullPathSpaceSticksToItsFirstDevice) {
  omni_test_set_device("left", 0, nullptr);
  App app;
  Start(app);
  const XrSpace any = app.ActionSpace(app.pose, XR_NULL_PATH);
  service.Fill();
  EXPECT_EQ(Locate(any, local, Now_ns()).location.locationFlags, kSeen);
  omni_test_set_device("left", 1, kTouch);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_LT(glm::length(Locate(any, pen, Now_ns()).p()), 1e-6) << "the same entity as the pen";
  service.SetFlags(0);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(Locate(any, local, Now_ns()).location.locationFlags, 0u) << "not the left controller";
}

// [CTS ActionSpaces] two that are there from the first sync on: the left hand's, which is the runtime's here.
TEST_F(Spaces, NullPathSpaceOfTwoHandsIsTheLeftOnes) {
  App app;
  Start(app);
  const XrSpace any = app.ActionSpace(app.pose, XR_NULL_PATH), left = app.ActionSpace(app.pose, app.left);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(Locate(any, local, Now_ns()).location.locationFlags, kSeen);
  EXPECT_LT(glm::length(Locate(any, left, Now_ns()).p()), 1e-6);
  omni_test_set_device("left", 0, nullptr);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(Locate(any, local, Now_ns()).location.locationFlags, 0u) << "not the pen";
}

TEST_F(Spaces, GripLiesBehindTheTip) {
  AppOptions options;
  options.profiles = {kSimple};  // binds grip
  App app(options);
  service.SetTrajectory(Along(Lissajous));
  ASSERT_TRUE(app.WaitProfile(service, kSimple));
  local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  const XrSpace grip = app.ActionSpace(app.pose, app.right);
  ForgetOldPath(app);
  service.Fill();
  const std::int64_t t = Now_ns() - 20'000'000;
  const Motion truth = InLocal(WithOffset({0, 0, 0.05}, Lissajous(1e-9 * static_cast<double>(t))));
  EXPECT_LT(glm::length(Locate(grip, local, t).p() - truth.X.p), 1e-4);
}

// The application's threads locate while one syncs and polls: no data race (run under ThreadSanitizer).
TEST_F(Spaces, ConcurrentLocatesSucceed) {
  App app;
  Start(app);
  std::atomic<bool> stop{false};
  std::atomic<int> located{0};
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      while (!stop) {
        if (Locate(pen, local, Now_ns()).result == XR_SUCCESS) ++located;
        const XrSpace mine = app.ActionSpace(app.pose, app.right);
        Locate(mine, pen, Now_ns());
        xrDestroySpace(mine);
        app.Bool(app.select, app.right);
      }
    });
  }
  for (int i = 0; i < 60; ++i) {
    service.Fill();
    EXPECT_EQ(app.Sync(), XR_SUCCESS);
    app.Poll();
    const timespec pause{0, 2'000'000};
    nanosleep(&pause, nullptr);
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(located, 100);
}

}  // namespace test_spaces
}  // namespace omni::test
