// Spaces: where they are, how they move, when they cannot be located.

#include <atomic>
#include <cmath>
#include <limits>
#include <thread>

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {
namespace test_spaces {

const std::string kLeftGrip = "/user/hand/left/input/grip/pose";
const std::string kLeftAim = "/user/hand/left/input/aim/pose";

void ExpectNear(const XrVector3f& a, float x, float y, float z) {
  EXPECT_NEAR(a.x, x, 2e-6f);
  EXPECT_NEAR(a.y, y, 2e-6f);
  EXPECT_NEAR(a.z, z, 2e-6f);
}

class SpaceTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    Start();
    grip_ = AddAction("grip", XR_ACTION_TYPE_POSE_INPUT, {"left"});
    aim_ = AddAction("aim", XR_ACTION_TYPE_POSE_INPUT, {"left"});
    ASSERT_EQ(Suggest(kTouchPath, {{grip_, kLeftGrip}, {aim_, kLeftAim}}), XR_SUCCESS);
    AttachAndFocus();
    stage_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
    local_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  }

  XrAction grip_ = XR_NULL_HANDLE;
  XrAction aim_ = XR_NULL_HANDLE;
  XrSpace stage_ = XR_NULL_HANDLE;
  XrSpace local_ = XR_NULL_HANDLE;
};

TEST_F(SpaceTest, ReferenceSpacesHaveTheirDefaultPoses) {
  const Where local = Locate(local_, stage_);
  EXPECT_TRUE(local.valid() && local.tracked());
  ExpectNear(local.location.pose.position, 0, 1.6f, 0);
  const XrPosef turned{{0, std::sqrt(0.5f), 0, std::sqrt(0.5f)}, {1, 0, 0}};
  const XrSpace offset = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL, turned);
  ExpectNear(Locate(offset, local_).location.pose.position, 1, 0, 0);
  // Seen from the turned space (90 degrees about +Y), the origin of LOCAL lies along -Z.
  ExpectNear(Locate(local_, offset).location.pose.position, 0, 0, -1);
  ExpectNear(Locate(ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW), local_).location.pose.position, 0, 0, 0);
}

TEST_F(SpaceTest, LocatableOnlyAfterASyncThatMadeItActive) {
  const XrSpace space = ActionSpace(grip_, "left");
  EXPECT_FALSE(Locate(space, stage_).valid());
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const Where where = Locate(space, stage_);
  EXPECT_TRUE(where.valid() && where.tracked());
  ExpectNear(where.location.pose.position, -0.2f, 1.3f, -0.4f);
  ExpectNear(Locate(space, local_).location.pose.position, -0.2f, -0.3f, -0.4f);
  ASSERT_EQ(Sync({}), XR_SUCCESS);
  const Where inactive = Locate(space, stage_);
  EXPECT_EQ(inactive.result, XR_SUCCESS);
  EXPECT_EQ(inactive.location.locationFlags, 0U);
  EXPECT_EQ(inactive.velocity.velocityFlags, 0U);
}

// v = v_A + w x r: 2 rad/s about +Z with a lever of 0.5 m along +X adds 1 m/s along +Y.
TEST_F(SpaceTest, VelocityIncludesTheLeverArm) {
  const float pose[7] = {0, 1, 0, 0, 0, 0, 1};
  const float velocity[6] = {0.1f, 0, 0, 0, 0, 2};
  ASSERT_EQ(omni_test_set_pose(kLeftGrip.c_str(), pose, velocity), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const XrSpace space = ActionSpace(grip_, "left", {{0, 0, 0, 1}, {0.5f, 0, 0}});
  const XrTime time = Now();
  const Where where = Locate(space, stage_, time);
  EXPECT_EQ(where.velocity.velocityFlags, XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT);
  const float speed = std::hypot(where.velocity.linearVelocity.x - 0.1f, where.velocity.linearVelocity.y);
  EXPECT_NEAR(speed, 1.0f, 1e-5f);
  ExpectNear(where.velocity.angularVelocity, 0, 0, 2);
  // The pose and its velocity agree: central difference over 2 ms.
  const Where before = Locate(space, stage_, time - 1'000'000);
  const Where after = Locate(space, stage_, time + 1'000'000);
  const float slope = (after.location.pose.position.y - before.location.pose.position.y) / 0.002f;
  EXPECT_NEAR(slope, where.velocity.linearVelocity.y, 2e-3f);
}

// A moving base: what stands still in the world moves backwards in it.
TEST_F(SpaceTest, VelocityIsRelativeToTheBase) {
  const float pose[7] = {0, 1.6f, 0, 0, 0, 0, 1};
  const float velocity[6] = {0, 0, -0.3f, 0, 0, 0};
  ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const XrSpace view = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  ExpectNear(Locate(ActionSpace(grip_, "left"), view).velocity.linearVelocity, 0, 0, 0.3f);
}

// Both at rest in the world, the base turned by 90 degrees about +Y and spinning about +Y at 2 rad/s, 1 m away.
TEST_F(SpaceTest, VelocityIsInTheAxesOfATurningBase) {
  const float pose[7] = {-0.2f, 1.3f, 0.6f, 0, std::sqrt(0.5f), 0, std::sqrt(0.5f)};
  const float velocity[6] = {0, 0, 0, 0, 2, 0};
  ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const XrSpace view = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  const XrSpace grip = ActionSpace(grip_, "left");
  const XrTime time = Now();
  const Where where = Locate(grip, view, time);
  ExpectNear(where.velocity.angularVelocity, 0, -2, 0);
  const XrVector3f before = Locate(grip, view, time - 1'000'000).location.pose.position;
  const XrVector3f after = Locate(grip, view, time + 1'000'000).location.pose.position;
  const XrVector3f& v = where.velocity.linearVelocity;
  EXPECT_NEAR(std::hypot(v.x, v.z), 2.0f, 1e-4f);
  EXPECT_NEAR((after.x - before.x) / 0.002f, v.x, 5e-3f);
  EXPECT_NEAR((after.z - before.z) / 0.002f, v.z, 5e-3f);
}

TEST_F(SpaceTest, DeviceVanishesAtOnceAndReturnsAtSync) {
  const XrSpace space = ActionSpace(grip_, "left");
  ASSERT_EQ(Sync(), XR_SUCCESS);
  ASSERT_EQ(omni_test_set_device("left", 0, nullptr), 0);
  EXPECT_FALSE(Locate(space, stage_).valid());
  EXPECT_TRUE(PoseActive(grip_)) << "the state changes at the sync only";
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_FALSE(PoseActive(grip_));
  ASSERT_EQ(omni_test_set_device("left", 1, nullptr), 0);
  EXPECT_FALSE(Locate(space, stage_).valid());
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_TRUE(Locate(space, stage_).valid());
}

TEST_F(SpaceTest, TrackingLossKeepsThePoseValid) {
  const XrSpace space = ActionSpace(grip_, "left");
  ASSERT_EQ(Sync(), XR_SUCCESS);
  ASSERT_EQ(omni_test_set_tracking("left", 1, 0), 0);
  EXPECT_TRUE(Locate(space, stage_).valid());
  EXPECT_FALSE(Locate(space, stage_).tracked());
  ASSERT_EQ(omni_test_set_tracking("left", 0, 0), 0);
  EXPECT_FALSE(Locate(space, stage_).valid());
  EXPECT_EQ(omni_test_set_tracking("left", 0, 1), -1) << "tracked means valid";
  // Two spaces on the same source are rigidly joined, seen or not.
  const XrSpace shifted = ActionSpace(grip_, "left", {{0, 0, 0, 1}, {0, 0, 0.1f}});
  const Where joined = Locate(shifted, space);
  EXPECT_TRUE(joined.valid() && joined.tracked());
  ExpectNear(joined.location.pose.position, 0, 0, 0.1f);
}

TEST_F(SpaceTest, SpaceOutlivesItsAction) {
  const XrSpace space = ActionSpace(grip_, "left");
  ASSERT_EQ(xrDestroyAction(grip_), XR_SUCCESS);
  ASSERT_EQ(xrDestroyAction(aim_), XR_SUCCESS);
  ASSERT_EQ(Sync({{set_, Path("/user/hand/left")}}), XR_SUCCESS) << "the set still declares the subaction path";
  EXPECT_TRUE(Locate(space, stage_).valid());
  ASSERT_EQ(xrDestroyActionSet(set_), XR_SUCCESS);
  EXPECT_TRUE(Locate(space, stage_).valid());
}

TEST_F(SpaceTest, RecenterMovesLocalOnly) {
  const XrSpace space = ActionSpace(grip_, "left");
  ASSERT_EQ(Sync(), XR_SUCCESS);
  Poll();
  const float pose[7] = {0.5f, 0, 0, 0, 0, 0, 1};
  const XrTime before = Now();
  ASSERT_EQ(omni_test_recenter(pose, 1'000'000'000), 0);
  const auto events = Poll();
  ASSERT_EQ(events.size(), 1U);
  ASSERT_EQ(events[0].type, XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
  const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(events[0]);
  EXPECT_EQ(change.referenceSpaceType, XR_REFERENCE_SPACE_TYPE_LOCAL);
  EXPECT_EQ(change.poseValid, XR_TRUE);
  EXPECT_GE(change.changeTime, before + 1'000'000'000);
  ExpectNear(change.poseInPreviousSpace.position, 0.5f, 0, 0);
  ExpectNear(Locate(space, local_, change.changeTime - 1).location.pose.position, -0.2f, -0.3f, -0.4f);
  ExpectNear(Locate(space, local_, change.changeTime).location.pose.position, -0.7f, -0.3f, -0.4f);
  ExpectNear(Locate(space, stage_, change.changeTime).location.pose.position, -0.2f, 1.3f, -0.4f);
}

TEST_F(SpaceTest, InvalidArgumentsAreRejected) {
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const XrSpace space = ActionSpace(grip_, "left");
  for (const XrTime time : {XrTime{-1}, std::numeric_limits<XrTime>::min()}) {
    EXPECT_EQ(Locate(space, stage_, time).result, XR_ERROR_TIME_INVALID);
  }
  auto location = Make<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
  EXPECT_EQ(xrLocateSpace(space, stage_, 0, &location), XR_ERROR_TIME_INVALID);
  location.type = XR_TYPE_SPACE_VELOCITY;
  EXPECT_EQ(xrLocateSpace(space, stage_, 1, &location), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(xrDestroySpace(space), XR_SUCCESS);
  EXPECT_EQ(Locate(space, stage_).result, XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Locate(stage_, space).result, XR_ERROR_HANDLE_INVALID);

  auto action_info = Make<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
  XrSpace made = XR_NULL_HANDLE;
  action_info.action = grip_;
  EXPECT_EQ(xrCreateActionSpace(session_, &action_info, &made), XR_ERROR_POSE_INVALID);
  action_info.poseInActionSpace = kHere;
  action_info.subactionPath = Path("/user/hand/right");
  EXPECT_EQ(xrCreateActionSpace(session_, &action_info, &made), XR_ERROR_PATH_UNSUPPORTED);
  action_info.subactionPath = XrPath{1};
  EXPECT_EQ(xrCreateActionSpace(session_, &action_info, &made), XR_ERROR_PATH_INVALID);
  auto reference = Make<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  reference.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_UNBOUNDED_MSFT;
  reference.poseInReferenceSpace = kHere;
  EXPECT_EQ(xrCreateReferenceSpace(session_, &reference, &made), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
  reference.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  reference.poseInReferenceSpace.orientation.w = 2;
  EXPECT_EQ(xrCreateReferenceSpace(session_, &reference, &made), XR_ERROR_POSE_INVALID);
}

TEST_F(SpaceTest, CallsAreCounted) {
  const long before = omni_test_call_count("xrLocateSpace");
  Locate(local_, stage_);
  Locate(local_, stage_);
  EXPECT_EQ(omni_test_call_count("xrLocateSpace"), before + 2);
}

// Readers, a syncing thread and a changing world at once; every answer is one of the two poses, never a mixture.
TEST_F(SpaceTest, ConcurrentReadersNeverSeeMixedPoses) {
  const XrSpace space = ActionSpace(grip_, "left");
  ASSERT_EQ(Sync(), XR_SUCCESS);
  const float near[7] = {0, 1, 0, 0, 0, 0, 1};
  const float far[7] = {1, 2, 1, 0, 0, 0, 1};
  ASSERT_EQ(omni_test_set_pose(kLeftGrip.c_str(), near, nullptr), 0);
  std::atomic<bool> stop{false};
  std::atomic<long> wrong{0};
  std::atomic<long> located{0};
  const XrTime time = Now();
  std::vector<std::thread> readers;
  readers.reserve(3);
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      while (!stop) {
        const XrVector3f p = Locate(space, stage_, time).location.pose.position;
        if (!((p.x == 0 && p.y == 1) || (p.x == 1 && p.y == 2))) ++wrong;
        ++located;
      }
    });
  }
  for (int i = 0; i < 100 || located < 100; ++i) {
    ASSERT_EQ(omni_test_set_pose(kLeftGrip.c_str(), i % 2 == 0 ? far : near, nullptr), 0);
    ASSERT_EQ(Sync(), XR_SUCCESS);
    std::this_thread::yield();
  }
  stop = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace test_spaces
}  // namespace omni::runtime
