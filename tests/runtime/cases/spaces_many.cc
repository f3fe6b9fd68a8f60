// xrLocateSpaces of XR_KHR_locate_spaces, and other calls that take a space: hands, layers, moving origins.

#include <array>
#include <cmath>
#include <cstring>

#include "tests/runtime/cases/fixture.h"
#include "tests/runtime/newer_openxr.h"

namespace omni::runtime {
namespace test_spaces_many {

class ManySpacesTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    ASSERT_EQ(CreateInstance({XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
                              XR_KHR_LOCATE_SPACES_EXTENSION_NAME, XR_EXT_HAND_TRACKING_EXTENSION_NAME}),
              XR_SUCCESS);
    ASSERT_EQ(CreateSession(), XR_SUCCESS);
    stage_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
    local_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    view_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    locate_ = Function<PFN_xrLocateSpacesKHR>("xrLocateSpacesKHR");
  }

  template <class Function_>
  Function_ Function(const char* name) {
    PFN_xrVoidFunction found = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, name, &found), XR_SUCCESS) << name;
    return reinterpret_cast<Function_>(found);
  }

  XrSpace stage_ = XR_NULL_HANDLE, local_ = XR_NULL_HANDLE, view_ = XR_NULL_HANDLE;
  PFN_xrLocateSpacesKHR locate_ = nullptr;
};

// A query for two spaces, with velocities.
struct Question {
  explicit Question(XrSpace base, const std::array<XrSpace, 2>& of, XrTime time) : spaces(of) {
    info = {XR_TYPE_SPACES_LOCATE_INFO, nullptr, base, time, 2, spaces.data()};
    velocities = {XR_TYPE_SPACE_VELOCITIES, nullptr, 2, velocity.data()};
    locations = {XR_TYPE_SPACE_LOCATIONS, &velocities, 2, location.data()};
  }
  Question(const Question&) = delete;
  std::array<XrSpace, 2> spaces;
  std::array<XrSpaceLocationData, 2> location{};
  std::array<XrSpaceVelocityData, 2> velocity{};
  XrSpacesLocateInfo info{};
  XrSpaceVelocities velocities{};
  XrSpaceLocations locations{};
};

TEST_F(ManySpacesTest, LocateSpacesMatchesLocateSpace) {
  const float head[7] = {0.3f, 1.5f, -0.2f, 0, std::sqrt(0.5f), 0, std::sqrt(0.5f)};
  const float moving[6] = {0.1f, 0, 0.4f, 0, 1, 0};
  ASSERT_EQ(omni_test_set_head(head, moving), 0);
  Question question(view_, {local_, stage_}, Now());
  ASSERT_EQ(locate_(session_, &question.info, &question.locations), XR_SUCCESS);
  for (size_t i = 0; i < 2; ++i) {
    const Where alone = Locate(question.spaces[i], view_, question.info.time);
    EXPECT_EQ(question.location[i].locationFlags, alone.location.locationFlags);
    EXPECT_EQ(std::memcmp(&question.location[i].pose, &alone.location.pose, sizeof(XrPosef)), 0);
    EXPECT_EQ(question.velocity[i].velocityFlags, alone.velocity.velocityFlags);
    EXPECT_EQ(question.velocity[i].linearVelocity.x, alone.velocity.linearVelocity.x);
    EXPECT_EQ(question.velocity[i].angularVelocity.y, alone.velocity.angularVelocity.y);
  }
}

TEST_F(ManySpacesTest, InvalidCountsTimesAndHandlesAreRejected) {
  Question question(view_, {local_, stage_}, Now());
  question.info.spaceCount = 0;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_VALIDATION_FAILURE);
  question.info.spaceCount = 1;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_VALIDATION_FAILURE);
  question.info.spaceCount = 2;
  question.velocities.velocityCount = 1;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_VALIDATION_FAILURE);
  question.velocities.velocityCount = 2;
  question.info.time = 0;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_TIME_INVALID);
  question.info.time = Now();
  question.spaces[1] = XR_NULL_HANDLE;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_HANDLE_INVALID);
  question.spaces[1] = stage_;
  question.info.baseSpace = XR_NULL_HANDLE;
  EXPECT_EQ(locate_(session_, &question.info, &question.locations), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(locate_(session_, nullptr, &question.locations), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(locate_(session_, &question.info, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(ManySpacesTest, ExtensionFunctionsNeedTheirExtension) {
  PFN_xrVoidFunction found = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrLocateSpaces", &found), XR_ERROR_FUNCTION_UNSUPPORTED) << "1.1 only";
  DestroyInstance();
  ASSERT_EQ(CreateInstance({XR_MND_HEADLESS_EXTENSION_NAME}), XR_SUCCESS);
  for (const char* name : {"xrLocateSpacesKHR", "xrCreateHandTrackerEXT", "xrLocateHandJointsEXT"})
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, name, &found), XR_ERROR_FUNCTION_UNSUPPORTED) << name;
}

TEST_F(ManySpacesTest, HandMovesWithItsPalm) {
  XrHandTrackerCreateInfoEXT create{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, nullptr, XR_HAND_LEFT_EXT,
                                    XR_HAND_JOINT_SET_DEFAULT_EXT};
  XrHandTrackerEXT tracker = XR_NULL_HANDLE;
  ASSERT_EQ(Function<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT")(session_, &create, &tracker), XR_SUCCESS);
  const auto locate = Function<PFN_xrLocateHandJointsEXT>("xrLocateHandJointsEXT");
  const float palm[7] = {0.1f, 1, 0.2f, 0, 0, 0, 1};
  const float moving[6] = {0.5f, 0, 0, 0, 2, 0};
  ASSERT_EQ(omni_test_set_hand("left", 1, palm, moving), 0);
  std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> joints{};
  std::array<XrHandJointVelocityEXT, XR_HAND_JOINT_COUNT_EXT> rates{};
  XrHandJointVelocitiesEXT velocities{XR_TYPE_HAND_JOINT_VELOCITIES_EXT, nullptr, XR_HAND_JOINT_COUNT_EXT,
                                      rates.data()};
  XrHandJointLocationsEXT out{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, &velocities, XR_FALSE, XR_HAND_JOINT_COUNT_EXT,
                              joints.data()};
  XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, stage_, Now()};
  ASSERT_EQ(locate(tracker, &info, &out), XR_SUCCESS);
  EXPECT_EQ(out.isActive, XR_TRUE);
  EXPECT_NEAR(joints[0].pose.position.y, 1, 1e-6f);
  EXPECT_GT(joints[0].radius, 0);
  EXPECT_NEAR(rates[0].linearVelocity.x, 0.5f, 1e-6f) << "the palm itself";
  // -0.05 m along Z at the tip of the index finger, turning about +Y at 2 rad/s.
  EXPECT_NEAR(rates[10].linearVelocity.x, 0.5f - 2 * 0.05f, 5e-3f);
  ASSERT_EQ(omni_test_set_hand("left", 0, nullptr, nullptr), 0);
  ASSERT_EQ(locate(tracker, &info, &out), XR_SUCCESS);
  EXPECT_EQ(out.isActive, XR_FALSE);
  EXPECT_EQ(joints[3].locationFlags, 0U);
  out.jointCount = 25;
  EXPECT_EQ(locate(tracker, &info, &out), XR_ERROR_VALIDATION_FAILURE);
  out.jointCount = XR_HAND_JOINT_COUNT_EXT;
  info.time = -1;
  EXPECT_EQ(locate(tracker, &info, &out), XR_ERROR_TIME_INVALID);
  ASSERT_EQ(Function<PFN_xrDestroyHandTrackerEXT>("xrDestroyHandTrackerEXT")(tracker), XR_SUCCESS);
  EXPECT_EQ(locate(tracker, &info, &out), XR_ERROR_HANDLE_INVALID);
}

TEST_F(ManySpacesTest, SpaceChangeAppliesAtChangeTime) {
  Poll();
  const float pose[7] = {0, 0, 1, 0, 0, 0, 1};
  ASSERT_EQ(omni_test_move_space("stage", pose, 1'000'000'000, 0), 0);
  EXPECT_EQ(omni_test_move_space("view", pose, 0, 0), -1);
  const auto events = Poll();
  ASSERT_FALSE(events.empty());
  const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(events.back());
  ASSERT_EQ(change.type, XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING);
  EXPECT_EQ(change.referenceSpaceType, XR_REFERENCE_SPACE_TYPE_STAGE);
  EXPECT_EQ(change.poseValid, XR_FALSE);
  EXPECT_NEAR(Locate(local_, stage_, change.changeTime - 1).location.pose.position.z, 0, 1e-6f);
  EXPECT_NEAR(Locate(local_, stage_, change.changeTime).location.pose.position.z, -1, 1e-6f);
}

TEST_F(ManySpacesTest, VelocitiesCanBeSwitchedOff) {
  ASSERT_EQ(omni_test_report_velocities(0), 0);
  const Where where = Locate(view_, stage_);
  EXPECT_TRUE(where.valid());
  EXPECT_EQ(where.velocity.velocityFlags, 0U);
}

TEST_F(ManySpacesTest, StageCanBeMissing) {
  ASSERT_EQ(omni_test_offer_stage(0), 0);
  uint32_t count = 0;
  ASSERT_EQ(xrEnumerateReferenceSpaces(session_, 0, &count, nullptr), XR_SUCCESS);
  EXPECT_EQ(count, 2U);
  auto info = Make<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_STAGE;
  info.poseInReferenceSpace = kHere;
  XrSpace made = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &made), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
}

TEST_F(ManySpacesTest, EndFrameValidatesAndRecordsLayers) {
  Focus();
  auto frame = Make<XrFrameState>(XR_TYPE_FRAME_STATE);
  ASSERT_EQ(xrWaitFrame(session_, nullptr, &frame), XR_SUCCESS);
  ASSERT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
  auto quad = Make<XrCompositionLayerQuad>(XR_TYPE_COMPOSITION_LAYER_QUAD);
  quad.space = local_;
  quad.pose = {{0, 0, 0, 1}, {1, 2, 3}};
  const auto* layer = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&quad);
  auto end = Make<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  end.displayTime = frame.predictedDisplayTime;
  end.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
  end.layerCount = 1;
  end.layers = &layer;
  quad.type = XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR;
  EXPECT_EQ(xrEndFrame(session_, &end), XR_ERROR_LAYER_INVALID) << "its extension is not enabled";
  quad.type = XR_TYPE_COMPOSITION_LAYER_QUAD;
  ASSERT_EQ(xrEndFrame(session_, &end), XR_SUCCESS);
  OmniTestFrame seen{};
  ASSERT_EQ(omni_test_frame(&seen), 0);
  EXPECT_EQ(seen.info, &end);
  EXPECT_EQ(seen.layer_count, 1U);
  EXPECT_EQ(seen.layers[0].structure, &quad);
  EXPECT_EQ(seen.layers[0].pose[2], 3);
  EXPECT_EQ(seen.display_time, frame.predictedDisplayTime);
}

}  // namespace test_spaces_many
}  // namespace omni::runtime
