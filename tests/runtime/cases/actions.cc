// Names, subaction paths, suggestions, attaching, the current profile.

#include <cstdio>

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {
namespace test_actions {

constexpr auto kBoolean = XR_ACTION_TYPE_BOOLEAN_INPUT;
constexpr auto kPose = XR_ACTION_TYPE_POSE_INPUT;

class ActionTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    Start();
  }

  XrResult TrySet(const std::string& name, const std::string& localized) {
    auto info = Make<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
    std::snprintf(info.actionSetName, sizeof(info.actionSetName), "%s", name.c_str());
    std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "%s", localized.c_str());
    return xrCreateActionSet(instance_, &info, &last_set_);
  }

  int ProfileEvents() {
    int count = 0;
    for (const auto& event : Poll()) {
      if (event.type != XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) continue;
      EXPECT_EQ(reinterpret_cast<const XrEventDataInteractionProfileChanged&>(event).session, session_);
      ++count;
    }
    return count;
  }

  XrActionSet last_set_ = XR_NULL_HANDLE;
};

TEST_F(ActionTest, InvalidSetNamesAreRejected) {
  EXPECT_EQ(TrySet("", "Text"), XR_ERROR_NAME_INVALID);
  EXPECT_EQ(TrySet("text", ""), XR_ERROR_LOCALIZED_NAME_INVALID);
  EXPECT_EQ(TrySet("Text", "Text"), XR_ERROR_PATH_FORMAT_INVALID);
  EXPECT_EQ(TrySet("..", "Text"), XR_ERROR_PATH_FORMAT_INVALID);
  EXPECT_EQ(TrySet("main", "Other"), XR_ERROR_NAME_DUPLICATED);
  EXPECT_EQ(TrySet("other", "The main"), XR_ERROR_LOCALIZED_NAME_DUPLICATED);
  ASSERT_EQ(TrySet("other", "Other"), XR_SUCCESS);
  ASSERT_EQ(xrDestroyActionSet(last_set_), XR_SUCCESS);
  EXPECT_EQ(TrySet("other", "Other"), XR_SUCCESS) << "the names are free again";
}

TEST_F(ActionTest, InvalidActionNamesAndSubactionPathsAreRejected) {
  XrAction action = XR_NULL_HANDLE;
  const XrPath left = Path("/user/hand/left");
  EXPECT_EQ(TryAction(set_, "", kBoolean, {}, &action), XR_ERROR_NAME_INVALID);
  EXPECT_EQ(TryAction(set_, "A", kBoolean, {}, &action), XR_ERROR_PATH_FORMAT_INVALID);
  EXPECT_EQ(TryAction(set_, "a", static_cast<XrActionType>(77), {}, &action), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {XrPath{1}}, &action), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {XR_NULL_PATH}, &action), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {Path("/user/hand/left/input/grip")}, &action), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {left, left}, &action), XR_ERROR_PATH_UNSUPPORTED);
  ASSERT_EQ(TryAction(set_, "a", kBoolean, {left}, &action), XR_SUCCESS);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {left}, &action), XR_ERROR_NAME_DUPLICATED);
  ASSERT_EQ(xrDestroyAction(action), XR_SUCCESS);
  EXPECT_EQ(xrDestroyAction(action), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(TryAction(set_, "a", kBoolean, {left}, &action), XR_SUCCESS);
  ASSERT_EQ(xrDestroyActionSet(set_), XR_SUCCESS);
  EXPECT_EQ(xrDestroyAction(action), XR_ERROR_HANDLE_INVALID) << "actions are destroyed with their set";
}

TEST_F(ActionTest, SuggestionsAreValidated) {
  const XrAction click = AddAction("click", kBoolean);
  EXPECT_EQ(Suggest("/interaction_profiles/logitech/mx_ink_stylus_logitech",
                    {{click, "/user/hand/left/input/tip_logitech/force"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Suggest(kTouchPath, {}), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/right/input/x/click"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/head/input/trigger/value"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/select/click"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(Suggest(kTouchPath, {{XR_NULL_HANDLE, "/user/hand/left/input/x/click"}}), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/x/click"}}), XR_SUCCESS);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/thumbstick"}}), XR_SUCCESS) << "parent paths are legal";
}

TEST_F(ActionTest, FailedSuggestionChangesNothing) {
  const XrAction click = AddAction("click", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/x/click"}}), XR_SUCCESS);
  ASSERT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/y/click"}, {click, "/user/hand/left/input/a/click"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  AttachAndFocus();
  ASSERT_EQ(omni_test_set_bool("/user/hand/left/input/y/click", 1), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).currentState, XR_FALSE);
  ASSERT_EQ(omni_test_set_bool("/user/hand/left/input/x/click", 1), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).currentState, XR_TRUE);
}

TEST_F(ActionTest, SecondSuggestionReplacesTheFirst) {
  const XrAction click = AddAction("click", kBoolean);
  ASSERT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/x/click"}}), XR_SUCCESS);
  ASSERT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/y/click"}}), XR_SUCCESS);
  AttachAndFocus();
  omni_test_set_bool("/user/hand/left/input/x/click", 1);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Boolean(click).currentState, XR_FALSE);
}

TEST_F(ActionTest, AttachedSetsAreImmutable) {
  const XrAction click = AddAction("click", kBoolean);
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  XrAction late = XR_NULL_HANDLE;
  EXPECT_EQ(TryAction(set_, "late", kBoolean, {}, &late), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  EXPECT_EQ(Suggest(kTouchPath, {{click, "/user/hand/left/input/x/click"}}), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  EXPECT_EQ(Attach({set_}), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
  EXPECT_EQ(Attach({AddSet("second")}), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
}

TEST_F(ActionTest, AttachChecksItsArguments) {
  EXPECT_EQ(Attach({}), XR_ERROR_VALIDATION_FAILURE);
  const XrActionSet gone = AddSet("gone");
  ASSERT_EQ(xrDestroyActionSet(gone), XR_SUCCESS);
  EXPECT_EQ(Attach({gone}), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Attach({set_}), XR_SUCCESS) << "a failed call attaches nothing";
}

TEST_F(ActionTest, ProfileIsCurrentOnlyAfterASync) {
  const XrAction pose = AddAction("pose", kPose, {"left", "right"});
  ASSERT_EQ(Suggest(kTouchPath, {{pose, "/user/hand/left/input/grip/pose"}}), XR_SUCCESS);
  XrPath profile = XR_NULL_PATH;
  EXPECT_EQ(Current(Path("/user/hand/left"), &profile), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  AttachAndFocus();
  EXPECT_EQ(CurrentProfile("/user/hand/left"), "");
  EXPECT_EQ(ProfileEvents(), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(CurrentProfile("/user/hand/left"), kTouchPath);
  EXPECT_EQ(CurrentProfile("/user/hand/right"), "") << "no device there";
  EXPECT_EQ(CurrentProfile("/user/head"), "");
  EXPECT_EQ(ProfileEvents(), 1);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(ProfileEvents(), 0) << "no event without a change";
}

TEST_F(ActionTest, CurrentProfileChecksItsPath) {
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  XrPath profile = XR_NULL_PATH;
  EXPECT_EQ(Current(XR_NULL_PATH, &profile), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(Current(XrPath{1}, &profile), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(Current(Path("/user/hand"), &profile), XR_ERROR_PATH_UNSUPPORTED);
}

TEST_F(ActionTest, UnsuggestedProfileNeverBecomesCurrent) {
  const XrAction pose = AddAction("pose", kPose);
  ASSERT_EQ(Suggest(kSimplePath, {{pose, "/user/hand/left/input/grip/pose"}}), XR_SUCCESS);
  AttachAndFocus();
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(CurrentProfile("/user/hand/left"), "");
  EXPECT_FALSE(PoseActive(pose));
  EXPECT_EQ(ProfileEvents(), 0);
  ASSERT_EQ(omni_test_set_device("left", 1, kSimplePath.c_str()), 0);
  EXPECT_EQ(CurrentProfile("/user/hand/left"), "") << "not before the sync";
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(CurrentProfile("/user/hand/left"), kSimplePath);
  EXPECT_TRUE(PoseActive(pose));
  EXPECT_EQ(ProfileEvents(), 1);
}

TEST_F(ActionTest, BothHandsChangeWithOneEvent) {
  const XrAction pose = AddAction("pose", kPose, {"left", "right"});
  ASSERT_EQ(
      Suggest(kTouchPath, {{pose, "/user/hand/left/input/grip/pose"}, {pose, "/user/hand/right/input/grip/pose"}}),
      XR_SUCCESS);
  AttachAndFocus();
  ASSERT_EQ(omni_test_set_device("right", 1, nullptr), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(CurrentProfile("/user/hand/right"), kTouchPath);
  EXPECT_EQ(ProfileEvents(), 1);
  ASSERT_EQ(omni_test_set_device("left", 0, nullptr), 0);
  ASSERT_EQ(omni_test_set_device("right", 0, nullptr), 0);
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(CurrentProfile("/user/hand/left"), "");
  EXPECT_EQ(CurrentProfile("/user/hand/right"), "");
  EXPECT_EQ(ProfileEvents(), 1);
}

TEST_F(ActionTest, HooksRejectUnknownDevicesAndPaths) {
  EXPECT_EQ(omni_test_set_device("middle", 1, nullptr), -1);
  EXPECT_EQ(omni_test_set_device("left", 1, "/interaction_profiles/nobody/nothing"), -1);
  EXPECT_EQ(omni_test_set_bool("/user/hand/left/input/trigger/value", 1), -1) << "a float";
  EXPECT_EQ(omni_test_set_float("/user/hand/left/input/trigger/value", 1.5f), -1);
  EXPECT_EQ(omni_test_set_bool("/user/hand/left/input/a/click", 1), -1) << "on the right only";
  const float flat[7] = {0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(omni_test_set_pose("/user/hand/left/input/grip/pose", flat, nullptr), -1);
  EXPECT_EQ(omni_test_recenter(flat, 0), -1);
  EXPECT_EQ(omni_test_call_count("xrNobody"), -1);
}

}  // namespace test_actions
}  // namespace omni::runtime
