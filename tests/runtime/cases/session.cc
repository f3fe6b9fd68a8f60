// Session states, focus, exit, loss, frames.

#include <array>

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {
namespace test_session {

using States = std::vector<XrSessionState>;

class SessionTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    Start();
  }

  XrResult Wait(XrFrameState* frame) { return xrWaitFrame(session_, nullptr, frame); }
  XrResult Begin() { return xrBeginFrame(session_, nullptr); }
  XrResult End(XrTime time, uint32_t layers = 0, const XrCompositionLayerBaseHeader* const* layer = nullptr,
               XrEnvironmentBlendMode mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE) {
    auto info = Make<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
    info.displayTime = time;
    info.environmentBlendMode = mode;
    info.layerCount = layers;
    info.layers = layer;
    return xrEndFrame(session_, &info);
  }
};

TEST_F(SessionTest, NeedsHeadlessOrGraphics) {
  DestroyInstance();
  ASSERT_EQ(CreateInstance({XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME}), XR_SUCCESS);
  EXPECT_EQ(CreateSession(), XR_ERROR_GRAPHICS_DEVICE_INVALID);
}

TEST_F(SessionTest, BeginAndEndNeedTheRightSessionState) {
  const auto info = Make<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_SESSION_NOT_READY);
  EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
  EXPECT_EQ(xrRequestExitSession(session_), XR_ERROR_SESSION_NOT_RUNNING);
  Focus();
  EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_SESSION_RUNNING);
  EXPECT_EQ(xrEndSession(session_), XR_ERROR_SESSION_NOT_STOPPING);
}

TEST_F(SessionTest, BeginsInAViewConfigurationThatTheSystemHas) {
  (void)PollStates();
  auto info = Make<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
  EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM;
  EXPECT_EQ(xrBeginSession(session_, &info), XR_ERROR_VALIDATION_FAILURE);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  EXPECT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
}

TEST_F(SessionTest, ExitPassesEveryStateInOrder) {
  Focus();
  ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
  EXPECT_EQ(PollStates(), (States{XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_STOPPING}));
  ASSERT_EQ(xrEndSession(session_), XR_SUCCESS);
  EXPECT_EQ(PollStates(), (States{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_EXITING}));
  EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
  EXPECT_EQ(xrDestroySession(session_), XR_ERROR_HANDLE_INVALID);
}

TEST_F(SessionTest, LosingFocusMakesActionsInactive) {
  XrAction pose = AddAction("pose", XR_ACTION_TYPE_POSE_INPUT);
  ASSERT_EQ(Suggest(kTouchPath, {{pose, "/user/hand/left/input/grip/pose"}}), XR_SUCCESS);
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  EXPECT_EQ(Sync(), XR_SESSION_NOT_FOCUSED);
  Focus();
  EXPECT_EQ(Sync(), XR_SUCCESS);
  EXPECT_TRUE(PoseActive(pose));
  ASSERT_EQ(omni_test_set_focus(0), 0);
  EXPECT_EQ(Sync(), XR_SESSION_NOT_FOCUSED);
  EXPECT_FALSE(PoseActive(pose));
  EXPECT_EQ(PollStates(), (States{XR_SESSION_STATE_VISIBLE}));
  ASSERT_EQ(omni_test_set_focus(1), 0);
  EXPECT_EQ(PollStates(), (States{XR_SESSION_STATE_FOCUSED}));
  EXPECT_EQ(Sync(), XR_SUCCESS);
  EXPECT_TRUE(PoseActive(pose));
}

TEST_F(SessionTest, LostSessionAllowsOnlyDestruction) {
  const XrSpace space = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  Focus();
  ASSERT_EQ(omni_test_lose_session(), 0);
  EXPECT_EQ(PollStates(), (States{XR_SESSION_STATE_LOSS_PENDING}));
  EXPECT_EQ(Sync({}), XR_ERROR_SESSION_LOST);
  EXPECT_EQ(Locate(space, space).result, XR_ERROR_SESSION_LOST);
  EXPECT_EQ(xrDestroySession(session_), XR_SUCCESS);
  EXPECT_EQ(CreateSession(), XR_SUCCESS);
}

TEST_F(SessionTest, DestroyingSessionInvalidatesItsSpaces) {
  const XrSpace space = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
  EXPECT_EQ(xrDestroySpace(space), XR_ERROR_HANDLE_INVALID);
  // A handle is never reused, even though its slot is.
  ASSERT_EQ(CreateSession(), XR_SUCCESS);
  EXPECT_NE(ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL), space);
}

TEST_F(SessionTest, UnpolledEventsAreCountedAsLost) {
  Focus();
  for (int i = 0; i < 300; ++i) {
    omni_test_set_focus(0);
    omni_test_set_focus(1);
  }
  const auto events = Poll();
  ASSERT_EQ(events.size(), 257U);
  ASSERT_EQ(events[0].type, XR_TYPE_EVENT_DATA_EVENTS_LOST);
  EXPECT_EQ(reinterpret_cast<const XrEventDataEventsLost&>(events[0]).lostEventCount, 600U - 256U);
}

TEST_F(SessionTest, FrameCallsMustComeInOrder) {
  auto frame = Make<XrFrameState>(XR_TYPE_FRAME_STATE);
  EXPECT_EQ(Wait(&frame), XR_ERROR_SESSION_NOT_RUNNING);
  Focus();
  EXPECT_EQ(Begin(), XR_ERROR_CALL_ORDER_INVALID);
  EXPECT_EQ(End(1), XR_ERROR_CALL_ORDER_INVALID);
  ASSERT_EQ(Wait(&frame), XR_SUCCESS);
  EXPECT_EQ(frame.predictedDisplayPeriod, 1'000'000'000 / 90);
  EXPECT_GT(frame.predictedDisplayTime, Now() - 1'000'000'000);
  EXPECT_EQ(frame.shouldRender, XR_FALSE);
  ASSERT_EQ(Begin(), XR_SUCCESS);
  EXPECT_EQ(End(0), XR_ERROR_TIME_INVALID);
  EXPECT_EQ(End(1, 0, nullptr, XR_ENVIRONMENT_BLEND_MODE_ADDITIVE), XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED);
  EXPECT_EQ(End(frame.predictedDisplayTime, 1, nullptr), XR_ERROR_LAYER_INVALID);
  EXPECT_EQ(End(frame.predictedDisplayTime), XR_SUCCESS);
  const XrTime first = frame.predictedDisplayTime;
  ASSERT_EQ(Wait(&frame), XR_SUCCESS);
  EXPECT_GE(frame.predictedDisplayTime - first, frame.predictedDisplayPeriod);
  ASSERT_EQ(Begin(), XR_SUCCESS);
  ASSERT_EQ(Wait(&frame), XR_SUCCESS);
  EXPECT_EQ(Begin(), XR_FRAME_DISCARDED);
}

TEST_F(SessionTest, LayersNeedValidSpaceAndPose) {
  const XrSpace space = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  Focus();
  auto frame = Make<XrFrameState>(XR_TYPE_FRAME_STATE);
  ASSERT_EQ(Wait(&frame), XR_SUCCESS);
  ASSERT_EQ(Begin(), XR_SUCCESS);
  auto quad = Make<XrCompositionLayerQuad>(XR_TYPE_COMPOSITION_LAYER_QUAD);
  quad.space = space;
  const auto* const layer = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&quad);
  ASSERT_EQ(xrDestroySpace(space), XR_SUCCESS);
  EXPECT_EQ(End(frame.predictedDisplayTime, 1, &layer), XR_ERROR_HANDLE_INVALID);
  quad.space = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  EXPECT_EQ(End(frame.predictedDisplayTime, 1, &layer), XR_ERROR_POSE_INVALID);
  quad.pose = kHere;
  EXPECT_EQ(End(frame.predictedDisplayTime, 1, &layer), XR_SUCCESS);
}

TEST_F(SessionTest, LocateViewsPlacesEyesAtTheHead) {
  Focus();
  const XrSpace stage = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
  auto info = Make<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
  info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  info.space = stage;
  info.displayTime = Now();
  auto state = Make<XrViewState>(XR_TYPE_VIEW_STATE);
  std::array<XrView, 2> views{Make<XrView>(XR_TYPE_VIEW), Make<XrView>(XR_TYPE_VIEW)};
  uint32_t count = 0;
  ASSERT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()), XR_SUCCESS);
  EXPECT_EQ(count, 2U);
  EXPECT_NEAR(views[0].pose.position.x, -0.032f, 1e-6f);
  EXPECT_NEAR(views[1].pose.position.x, 0.032f, 1e-6f);
  EXPECT_NEAR(views[1].pose.position.y, 1.6f, 1e-6f);
  EXPECT_EQ(state.viewStateFlags & XR_VIEW_STATE_POSITION_TRACKED_BIT, XR_VIEW_STATE_POSITION_TRACKED_BIT);
  EXPECT_EQ(xrLocateViews(session_, &info, &state, 1, &count, views.data()), XR_ERROR_SIZE_INSUFFICIENT);
  info.displayTime = 0;
  EXPECT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()), XR_ERROR_TIME_INVALID);
  info.displayTime = 1;
  info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
  EXPECT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()),
            XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
}

}  // namespace test_session
}  // namespace omni::runtime
