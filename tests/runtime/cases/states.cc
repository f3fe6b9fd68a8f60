// Action states: values, conversions, change times, subaction paths, priorities, sources.

#include <cmath>

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {
namespace test_states {

constexpr auto kBoolean = XR_ACTION_TYPE_BOOLEAN_INPUT;
constexpr auto kFloat = XR_ACTION_TYPE_FLOAT_INPUT;
constexpr auto kVector2 = XR_ACTION_TYPE_VECTOR2F_INPUT;
constexpr auto kPose = XR_ACTION_TYPE_POSE_INPUT;
const std::string kLeftX = "/user/hand/left/input/x/click";
const std::string kLeftTrigger = "/user/hand/left/input/trigger/value";

class StateTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    Start();
  }
};

TEST_F(StateTest, BooleanChangesAtSyncsWithPhysicalTime) {
  const XrAction click = AddAction("click", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{click, kLeftX}}), XR_SUCCESS);
  AttachAndFocus();
  ASSERT_EQ(Sync(), XR_SUCCESS);
  XrActionStateBoolean state = Boolean(click);
  EXPECT_EQ(state.isActive, XR_TRUE);
  EXPECT_EQ(state.currentState, XR_FALSE);
  EXPECT_EQ(state.changedSinceLastSync, XR_FALSE);

  const XrTime before = Now();
  ASSERT_EQ(omni_test_set_bool(kLeftX.c_str(), 1), 0);
  const XrTime after = Now();
  EXPECT_EQ(Boolean(click).currentState, XR_FALSE) << "constant between two syncs";
  ASSERT_EQ(Sync(), XR_SUCCESS);
  state = Boolean(click);
  EXPECT_EQ(state.currentState, XR_TRUE);
  EXPECT_EQ(state.changedSinceLastSync, XR_TRUE);
  EXPECT_GE(state.lastChangeTime, before);
  EXPECT_LE(state.lastChangeTime, after);

  ASSERT_EQ(Sync(), XR_SUCCESS);
  const XrActionStateBoolean later = Boolean(click);
  EXPECT_EQ(later.changedSinceLastSync, XR_FALSE);
  EXPECT_EQ(later.lastChangeTime, state.lastChangeTime);
}

TEST_F(StateTest, InactiveStatesAreZero) {
  const XrAction click = AddAction("click", kBoolean);
  const XrAction pull = AddAction("pull", kFloat);
  ASSERT_EQ(Suggest(kTouchPath, {{click, kLeftX}, {pull, kLeftTrigger}}), XR_SUCCESS);
  AttachAndFocus();
  omni_test_set_bool(kLeftX.c_str(), 1);
  omni_test_set_float(kLeftTrigger.c_str(), 0.75f);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).currentState, XR_TRUE);
  EXPECT_EQ(Float(pull).currentState, 0.75f);
  ASSERT_EQ(Sync({}), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).isActive, XR_FALSE);
  EXPECT_EQ(Boolean(click).currentState, XR_FALSE);
  EXPECT_EQ(Boolean(click).changedSinceLastSync, XR_FALSE);
  EXPECT_EQ(Boolean(click).lastChangeTime, 0);
  EXPECT_EQ(Float(pull).currentState, 0.0f);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).currentState, XR_TRUE);
  EXPECT_EQ(Boolean(click).changedSinceLastSync, XR_FALSE) << "was not active in the sync before";
}

TEST_F(StateTest, AnalogueToBooleanHasHysteresis) {
  const XrAction click = AddAction("click", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{click, kLeftTrigger}}), XR_SUCCESS);
  AttachAndFocus();
  const auto at = [&](float value) {
    EXPECT_EQ(omni_test_set_float(kLeftTrigger.c_str(), value), 0);
    EXPECT_EQ(Sync(), XR_SUCCESS);
    return Boolean(click).currentState == XR_TRUE;
  };
  EXPECT_FALSE(at(0.6f));
  EXPECT_TRUE(at(0.8f));
  EXPECT_TRUE(at(0.6f));
  EXPECT_FALSE(at(0.4f));
  EXPECT_FALSE(at(0.6f));
}

TEST_F(StateTest, ParentPathsConvertToActionType) {
  const XrAction pull = AddAction("pull", kFloat);
  const XrAction press = AddAction("press", kFloat);
  const XrAction stick = AddAction("stick", kVector2);
  const XrAction half = AddAction("half", kFloat);
  const XrAction stick_click = AddAction("stick_click", kBoolean);
  const XrAction wrong = AddAction("wrong", kVector2);
  ASSERT_EQ(Suggest(kTouchPath, {{pull, "/user/hand/left/input/trigger"},
                                 {press, kLeftX},
                                 {stick, "/user/hand/left/input/thumbstick"},
                                 {half, "/user/hand/left/input/thumbstick/y"},
                                 {stick_click, "/user/hand/left/input/thumbstick"},
                                 {wrong, kLeftX}}),
            XR_SUCCESS);
  AttachAndFocus();
  omni_test_set_float(kLeftTrigger.c_str(), 0.25f);
  omni_test_set_bool(kLeftX.c_str(), 1);
  omni_test_set_vector2("/user/hand/left/input/thumbstick", 0.5f, -0.25f);
  omni_test_set_bool("/user/hand/left/input/thumbstick/click", 1);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Float(pull).currentState, 0.25f);
  EXPECT_EQ(Float(press).currentState, 1.0f);
  EXPECT_EQ(Vector2(stick).currentState.x, 0.5f);
  EXPECT_EQ(Vector2(stick).currentState.y, -0.25f);
  EXPECT_EQ(Float(half).currentState, -0.25f);
  EXPECT_EQ(Boolean(stick_click).currentState, XR_TRUE);
  EXPECT_EQ(Vector2(wrong).isActive, XR_FALSE) << "a path that cannot be converted is not bound";
}

TEST_F(StateTest, SubactionPathsSeparateHands) {
  const XrAction pull = AddAction("pull", kFloat, {"left", "right"});
  const std::string right = "/user/hand/right/input/trigger/value";
  ASSERT_EQ(Suggest(kTouchPath, {{pull, kLeftTrigger}, {pull, right}}), XR_SUCCESS);
  AttachAndFocus();
  omni_test_set_device("right", 1, nullptr);
  omni_test_set_float(kLeftTrigger.c_str(), 0.3f);
  omni_test_set_float(right.c_str(), 0.6f);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Float(pull, "left").currentState, 0.3f);
  EXPECT_EQ(Float(pull, "right").currentState, 0.6f);
  EXPECT_EQ(Float(pull).currentState, 0.6f) << "the larger of both";
  ASSERT_EQ(Sync({{set_, Path("/user/hand/left")}}), XR_SUCCESS);
  EXPECT_EQ(Float(pull, "left").currentState, 0.3f);
  EXPECT_EQ(Float(pull, "right").isActive, XR_FALSE);
  EXPECT_EQ(Float(pull).currentState, 0.3f);
}

TEST_F(StateTest, BooleansOfTwoHandsAreOred) {
  const XrAction touch = AddAction("touch", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{touch, "/user/hand/left/input/thumbrest/touch"},
                                 {touch, "/user/hand/right/input/thumbrest/touch"}}),
            XR_SUCCESS);
  AttachAndFocus();
  omni_test_set_device("right", 1, nullptr);
  const auto at = [&](int left, int right) {
    omni_test_set_bool("/user/hand/left/input/thumbrest/touch", left);
    omni_test_set_bool("/user/hand/right/input/thumbrest/touch", right);
    EXPECT_EQ(Sync(), XR_SUCCESS);
    return Boolean(touch).currentState == XR_TRUE;
  };
  EXPECT_FALSE(at(0, 0));
  EXPECT_TRUE(at(1, 0));
  EXPECT_TRUE(at(0, 1));
  EXPECT_TRUE(at(1, 1));
  EXPECT_FALSE(at(0, 0));
}

TEST_F(StateTest, InvalidQueriesAreRejected) {
  const XrAction click = AddAction("click", kBoolean, {"left"});
  auto info = Make<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
  auto state = Make<XrActionStateBoolean>(XR_TYPE_ACTION_STATE_BOOLEAN);
  auto pull = Make<XrActionStateFloat>(XR_TYPE_ACTION_STATE_FLOAT);
  info.action = click;
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_SUCCESS);
  EXPECT_EQ(xrGetActionStateFloat(session_, &info, &pull), XR_ERROR_ACTION_TYPE_MISMATCH);
  info.subactionPath = Path("/user/hand/right");
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_PATH_UNSUPPORTED);
  info.subactionPath = XrPath{1};
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_PATH_INVALID);
  info.subactionPath = XR_NULL_PATH;
  state.type = XR_TYPE_ACTION_STATE_FLOAT;
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(xrDestroyAction(click), XR_SUCCESS);
  EXPECT_EQ(xrGetActionStateBoolean(session_, &info, &state), XR_ERROR_HANDLE_INVALID);
}

TEST_F(StateTest, InvalidSyncsAreRejected) {
  AddAction("click", kBoolean, {"left"});
  EXPECT_EQ(Sync(), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  Focus();
  EXPECT_EQ(Sync({}), XR_SUCCESS) << "nothing attached, nothing synced";
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  EXPECT_EQ(Sync({{AddSet("other"), XR_NULL_PATH}}), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_EQ(Sync({{set_, Path("/user/hand/right")}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Sync({{set_, XrPath{1}}}), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(Sync({{set_, Path("/user/hand/left")}}), XR_SUCCESS);
}

// The trigger belongs to the set with the higher priority, whatever the component; the other button to both.
TEST_F(StateTest, HigherPriorityTakesTheSource) {
  const XrActionSet high = AddSet("high", 5);
  const XrAction low_pull = AddAction("low_pull", kFloat);
  const XrAction low_click = AddAction("low_click", kBoolean);
  const XrAction high_touch = AddActionTo(high, "high_touch", kBoolean);
  ASSERT_EQ(
      Suggest(kTouchPath,
              {{low_pull, kLeftTrigger}, {low_click, kLeftX}, {high_touch, "/user/hand/left/input/trigger/touch"}}),
      XR_SUCCESS);
  ASSERT_EQ(Attach({set_, high}), XR_SUCCESS);
  Focus();
  omni_test_set_float(kLeftTrigger.c_str(), 0.5f);
  omni_test_set_bool(kLeftX.c_str(), 1);
  ASSERT_EQ(Sync({{set_, XR_NULL_PATH}, {high, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_EQ(Float(low_pull).isActive, XR_FALSE);
  EXPECT_EQ(Boolean(high_touch).isActive, XR_TRUE);
  EXPECT_EQ(Boolean(low_click).currentState, XR_TRUE);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Float(low_pull).currentState, 0.5f) << "alone again";
}

TEST_F(StateTest, PoseStaysWithItsFirstDevice) {
  const XrAction pose = AddAction("pose", kPose);
  ASSERT_EQ(
      Suggest(kTouchPath, {{pose, "/user/hand/left/input/grip/pose"}, {pose, "/user/hand/right/input/grip/pose"}}),
      XR_SUCCESS);
  omni_test_set_device("left", 0, nullptr);
  omni_test_set_device("right", 1, nullptr);
  AttachAndFocus();
  const XrSpace space = ActionSpace(pose);
  const XrSpace stage = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_NEAR(Locate(space, stage).location.pose.position.x, 0.2f, 1e-6f);
  omni_test_set_device("left", 1, nullptr);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_NEAR(Locate(space, stage).location.pose.position.x, 0.2f, 1e-6f) << "the right hand was first";
  omni_test_set_device("right", 0, nullptr);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_FALSE(Locate(space, stage).valid()) << "[CTS ActionSpaces] it picks one device and stays with it";
  omni_test_set_device("right", 1, nullptr);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_NEAR(Locate(space, stage).location.pose.position.x, 0.2f, 1e-6f);
}

// XR_EXT_conformance_automation: what the hooks do, from inside of an application.
TEST_F(StateTest, AutomationMovesDevices) {
  ::setenv("OMNI_TEST_RUNTIME_AUTOMATION", "1", 1);
  DestroyInstance();
  ASSERT_EQ(CreateInstance({XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
                            XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME}),
            XR_SUCCESS);
  ::unsetenv("OMNI_TEST_RUNTIME_AUTOMATION");
  ASSERT_EQ(CreateSession(), XR_SUCCESS);
  set_ = AddSet("automation");
  const auto function = [this](const char* name) {
    PFN_xrVoidFunction found = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, name, &found), XR_SUCCESS) << name;
    return found;
  };
  const auto set_active = reinterpret_cast<PFN_xrSetInputDeviceActiveEXT>(function("xrSetInputDeviceActiveEXT"));
  const auto set_float = reinterpret_cast<PFN_xrSetInputDeviceStateFloatEXT>(function("xrSetInputDeviceStateFloatEXT"));
  const auto set_location = reinterpret_cast<PFN_xrSetInputDeviceLocationEXT>(function("xrSetInputDeviceLocationEXT"));
  const XrPath right = Path("/user/hand/right");
  const XrPath trigger = Path("/user/hand/right/input/trigger/value"), grip = Path("/user/hand/right/input/grip/pose");
  const XrAction pull = AddAction("pull", kFloat), pose = AddAction("pose", kPose);
  ASSERT_EQ(
      Suggest(kTouchPath, {{pull, "/user/hand/right/input/trigger/value"}, {pose, "/user/hand/right/input/grip/pose"}}),
      XR_SUCCESS);
  EXPECT_EQ(set_active(session_, Path(kTouchPath), right, XR_TRUE), XR_SUCCESS);
  EXPECT_EQ(set_float(session_, right, trigger, 0.75f), XR_SUCCESS);
  EXPECT_EQ(set_float(session_, Path("/user/hand/left"), trigger, 0.75f), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(set_float(session_, right, Path("/user/hand/right/input/no/value"), 0.75f), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(set_active(session_, right, right, XR_TRUE), XR_ERROR_PATH_UNSUPPORTED);
  const XrSpace stage = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
  EXPECT_EQ(set_location(session_, right, grip, stage, {{0, 0, 0, 1}, {1, 2, 3}}), XR_SUCCESS);
  AttachAndFocus();
  const XrSpace space = ActionSpace(pose);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_NEAR(Locate(space, stage).location.pose.position.y, 2, 1e-6f);
  EXPECT_FLOAT_EQ(Float(pull).currentState, 0.75f);
  EXPECT_EQ(set_active(session_, Path(kTouchPath), right, XR_FALSE), XR_SUCCESS);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_FALSE(Locate(space, stage).valid());
}

TEST_F(StateTest, BoundSourcesAreListedWithNames) {
  const XrAction click = AddAction("click", kBoolean);
  const XrAction unbound = AddAction("unbound", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{click, kLeftX}, {click, "/user/hand/left/input/trigger"}}), XR_SUCCESS);
  auto info = Make<XrBoundSourcesForActionEnumerateInfo>(XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO);
  info.action = click;
  uint32_t count = 9;
  EXPECT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 0, &count, nullptr), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  AttachAndFocus();
  ASSERT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 0, &count, nullptr), XR_SUCCESS);
  EXPECT_EQ(count, 0U) << "no sync yet";
  ASSERT_EQ(Sync(), XR_SUCCESS);
  XrPath sources[4] = {};
  EXPECT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 1, &count, sources), XR_ERROR_SIZE_INSUFFICIENT);
  ASSERT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 4, &count, sources), XR_SUCCESS);
  ASSERT_EQ(count, 2U);
  EXPECT_EQ(Text(sources[0]), kLeftX);
  EXPECT_EQ(Text(sources[1]), kLeftTrigger) << "the parent path stands for its value";
  info.action = unbound;
  ASSERT_EQ(xrEnumerateBoundSourcesForAction(session_, &info, 4, &count, sources + 2), XR_SUCCESS);
  EXPECT_EQ(count, 0U);

  auto name = Make<XrInputSourceLocalizedNameGetInfo>(XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO);
  name.sourcePath = sources[1];
  char text[128] = "";
  name.whichComponents = 7;
  ASSERT_EQ(xrGetInputSourceLocalizedName(session_, &name, sizeof(text), &count, text), XR_SUCCESS);
  EXPECT_STREQ(text, "Left Hand Touch Controller Trigger");
  name.whichComponents = XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;
  ASSERT_EQ(xrGetInputSourceLocalizedName(session_, &name, sizeof(text), &count, text), XR_SUCCESS);
  EXPECT_STREQ(text, "Trigger");
  EXPECT_EQ(count, 8U);
  name.whichComponents = 0;
  EXPECT_EQ(xrGetInputSourceLocalizedName(session_, &name, sizeof(text), &count, text), XR_ERROR_VALIDATION_FAILURE);
  name.whichComponents = 1;
  name.sourcePath = XR_NULL_PATH;
  EXPECT_EQ(xrGetInputSourceLocalizedName(session_, &name, sizeof(text), &count, text), XR_ERROR_PATH_INVALID);
}

TEST_F(StateTest, HapticsReachTheBoundHandOnly) {
  const XrAction buzz = AddAction("buzz", XR_ACTION_TYPE_VIBRATION_OUTPUT, {"left", "right"});
  ASSERT_EQ(Suggest(kTouchPath, {{buzz, "/user/hand/left/output/haptic"}, {buzz, "/user/hand/right/output/haptic"}}),
            XR_SUCCESS);
  omni_test_set_device("right", 1, nullptr);
  auto info = Make<XrHapticActionInfo>(XR_TYPE_HAPTIC_ACTION_INFO);
  info.action = buzz;
  info.subactionPath = Path("/user/hand/right");
  auto vibration = Make<XrHapticVibration>(XR_TYPE_HAPTIC_VIBRATION);
  vibration.duration = 20'000'000;
  vibration.frequency = 160;
  vibration.amplitude = 0.25f;
  const auto apply = [&] {
    return xrApplyHapticFeedback(session_, &info, reinterpret_cast<const XrHapticBaseHeader*>(&vibration));
  };
  EXPECT_EQ(apply(), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  EXPECT_EQ(apply(), XR_SESSION_NOT_FOCUSED);
  Focus();
  OmniTestHaptics left{};
  OmniTestHaptics right{};
  ASSERT_EQ(Sync({}), XR_SUCCESS);
  EXPECT_EQ(apply(), XR_SUCCESS);
  ASSERT_EQ(omni_test_haptics("right", &right), 0);
  EXPECT_EQ(right.count, 0U) << "the action is not active";
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(apply(), XR_SUCCESS);
  ASSERT_EQ(omni_test_haptics("left", &left), 0);
  ASSERT_EQ(omni_test_haptics("right", &right), 0);
  EXPECT_EQ(left.count, 0U);
  EXPECT_EQ(right.count, 1U);
  EXPECT_EQ(right.last_amplitude, 0.25f);
  EXPECT_EQ(right.last_frequency_Hz, 160.0f);
  EXPECT_EQ(right.last_duration_ns, 20'000'000);
  info.subactionPath = XR_NULL_PATH;
  vibration.duration = XR_MIN_HAPTIC_DURATION;
  EXPECT_EQ(apply(), XR_SUCCESS);
  EXPECT_EQ(xrStopHapticFeedback(session_, &info), XR_SUCCESS);
  omni_test_haptics("left", &left);
  EXPECT_EQ(left.count, 1U);
  EXPECT_EQ(left.stops, 1U);
  EXPECT_EQ(left.last_duration_ns, XR_MIN_HAPTIC_DURATION);
  vibration.amplitude = std::nanf("");
  EXPECT_EQ(apply(), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(omni_test_set_focus(0), 0);
  vibration.amplitude = 1;
  EXPECT_EQ(apply(), XR_SESSION_NOT_FOCUSED);
  EXPECT_EQ(xrStopHapticFeedback(session_, &info), XR_SESSION_NOT_FOCUSED);
}

}  // namespace test_states
}  // namespace omni::runtime
