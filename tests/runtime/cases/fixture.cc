#include "tests/runtime/cases/fixture.h"

#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace omni::runtime {

bool Where::valid() const {
  constexpr XrSpaceLocationFlags kBits = XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
  return (location.locationFlags & kBits) == kBits;
}

bool Where::tracked() const {
  constexpr XrSpaceLocationFlags kBits =
      XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
  return (location.locationFlags & kBits) == kBits;
}

void RuntimeTest::SetUp() {
  setenv("XR_RUNTIME_JSON", OMNI_TEST_RUNTIME_JSON, 1);
  unsetenv("XR_ENABLE_API_LAYERS");
  unsetenv("OMNI_TEST_RUNTIME_SCRIPT");
  ASSERT_EQ(omni_test_reset(), 0);
}

void RuntimeTest::TearDown() {
  DestroyInstance();
  EXPECT_EQ(omni_test_live_handles(), 0U) << "handles outlived their instance";
}

XrResult RuntimeTest::CreateInstance(const std::vector<const char*>& extensions, XrVersion api_version) {
  auto info = Make<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "runtime test");
  info.applicationInfo.apiVersion = api_version;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.enabledExtensionNames = extensions.data();
  return xrCreateInstance(&info, &instance_);
}

void RuntimeTest::DestroyInstance() {
  if (instance_ != XR_NULL_HANDLE) {
    EXPECT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
  }
  instance_ = XR_NULL_HANDLE;
  session_ = XR_NULL_HANDLE;
  set_ = XR_NULL_HANDLE;
}

XrResult RuntimeTest::CreateSession() {
  auto get = Make<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  auto info = Make<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  const XrResult result = xrGetSystem(instance_, &get, &info.systemId);
  return XR_FAILED(result) ? result : xrCreateSession(instance_, &info, &session_);
}

void RuntimeTest::Start() {
  const std::vector<const char*> extensions = {XR_MND_HEADLESS_EXTENSION_NAME,
                                               XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
  ASSERT_EQ(CreateInstance(extensions), XR_SUCCESS);
  ASSERT_EQ(CreateSession(), XR_SUCCESS);
  set_ = AddSet("main");
}

std::vector<XrEventDataBuffer> RuntimeTest::Poll() {
  std::vector<XrEventDataBuffer> events;
  for (;;) {
    auto event = Make<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    if (xrPollEvent(instance_, &event) != XR_SUCCESS) return events;
    events.push_back(event);
  }
}

std::vector<XrSessionState> RuntimeTest::PollStates() {
  std::vector<XrSessionState> states;
  for (const XrEventDataBuffer& event : Poll()) {
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    states.push_back(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state);
  }
  return states;
}

void RuntimeTest::Focus() {
  ASSERT_EQ(PollStates(), (std::vector<XrSessionState>{XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY}));
  auto info = Make<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
  ASSERT_EQ(PollStates(), (std::vector<XrSessionState>{XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE,
                                                       XR_SESSION_STATE_FOCUSED}));
}

XrPath RuntimeTest::Path(const std::string& text) {
  XrPath path = XR_NULL_PATH;
  EXPECT_EQ(xrStringToPath(instance_, text.c_str(), &path), XR_SUCCESS) << text;
  return path;
}

std::string RuntimeTest::Text(XrPath path) {
  char text[XR_MAX_PATH_LENGTH] = "";
  uint32_t length = 0;
  EXPECT_EQ(xrPathToString(instance_, path, sizeof(text), &length, text), XR_SUCCESS);
  EXPECT_EQ(length, std::string(text).size() + 1);
  return text;
}

XrActionSet RuntimeTest::AddSet(const std::string& name, uint32_t priority) {
  auto info = Make<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
  std::snprintf(info.actionSetName, sizeof(info.actionSetName), "%s", name.c_str());
  std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "The %s", name.c_str());
  info.priority = priority;
  XrActionSet set = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateActionSet(instance_, &info, &set), XR_SUCCESS);
  return set;
}

XrResult RuntimeTest::TryAction(XrActionSet set, const std::string& name, XrActionType type,
                                const std::vector<XrPath>& subactions, XrAction* action) {
  auto info = Make<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
  std::snprintf(info.actionName, sizeof(info.actionName), "%s", name.c_str());
  if (!name.empty()) std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "The %s", name.c_str());
  info.actionType = type;
  info.countSubactionPaths = static_cast<uint32_t>(subactions.size());
  info.subactionPaths = subactions.data();
  return xrCreateAction(set, &info, action);
}

XrAction RuntimeTest::AddActionTo(XrActionSet set, const std::string& name, XrActionType type,
                                  const std::vector<std::string>& hands) {
  std::vector<XrPath> paths;
  paths.reserve(hands.size());
  for (const std::string& hand : hands) paths.push_back(Path("/user/hand/" + hand));
  XrAction action = XR_NULL_HANDLE;
  EXPECT_EQ(TryAction(set, name, type, paths, &action), XR_SUCCESS);
  return action;
}

XrAction RuntimeTest::AddAction(const std::string& name, XrActionType type, const std::vector<std::string>& hands) {
  return AddActionTo(set_, name, type, hands);
}

XrResult RuntimeTest::Suggest(const std::string& profile, const std::vector<Binding>& bindings) {
  std::vector<XrActionSuggestedBinding> suggested;
  suggested.reserve(bindings.size());
  for (const Binding& binding : bindings) suggested.push_back({binding.action, Path(binding.path)});
  auto info = Make<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
  info.interactionProfile = Path(profile);
  info.countSuggestedBindings = static_cast<uint32_t>(suggested.size());
  info.suggestedBindings = suggested.data();
  return xrSuggestInteractionProfileBindings(instance_, &info);
}

XrResult RuntimeTest::Attach(const std::vector<XrActionSet>& sets) {
  auto info = Make<XrSessionActionSetsAttachInfo>(XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO);
  info.countActionSets = static_cast<uint32_t>(sets.size());
  info.actionSets = sets.data();
  return xrAttachSessionActionSets(session_, &info);
}

void RuntimeTest::AttachAndFocus() {
  ASSERT_EQ(Attach({set_}), XR_SUCCESS);
  Focus();
}

XrResult RuntimeTest::Sync(const std::vector<XrActiveActionSet>& active) {
  auto info = Make<XrActionsSyncInfo>(XR_TYPE_ACTIONS_SYNC_INFO);
  info.countActiveActionSets = static_cast<uint32_t>(active.size());
  info.activeActionSets = active.data();
  return xrSyncActions(session_, &info);
}

namespace {

template <class State, class Function>
State Get(XrSession session, XrAction action, XrPath subaction, XrStructureType type, Function function) {
  auto info = Make<XrActionStateGetInfo>(XR_TYPE_ACTION_STATE_GET_INFO);
  info.action = action;
  info.subactionPath = subaction;
  State state = Make<State>(type);
  EXPECT_EQ(function(session, &info, &state), XR_SUCCESS);
  return state;
}

}  // namespace

XrActionStateBoolean RuntimeTest::Boolean(XrAction action, const std::string& subaction) {
  const XrPath path = subaction.empty() ? XR_NULL_PATH : Path("/user/hand/" + subaction);
  return Get<XrActionStateBoolean>(session_, action, path, XR_TYPE_ACTION_STATE_BOOLEAN, xrGetActionStateBoolean);
}

XrActionStateFloat RuntimeTest::Float(XrAction action, const std::string& subaction) {
  const XrPath path = subaction.empty() ? XR_NULL_PATH : Path("/user/hand/" + subaction);
  return Get<XrActionStateFloat>(session_, action, path, XR_TYPE_ACTION_STATE_FLOAT, xrGetActionStateFloat);
}

XrActionStateVector2f RuntimeTest::Vector2(XrAction action, const std::string& subaction) {
  const XrPath path = subaction.empty() ? XR_NULL_PATH : Path("/user/hand/" + subaction);
  return Get<XrActionStateVector2f>(session_, action, path, XR_TYPE_ACTION_STATE_VECTOR2F, xrGetActionStateVector2f);
}

bool RuntimeTest::PoseActive(XrAction action, const std::string& subaction) {
  const XrPath path = subaction.empty() ? XR_NULL_PATH : Path("/user/hand/" + subaction);
  return Get<XrActionStatePose>(session_, action, path, XR_TYPE_ACTION_STATE_POSE, xrGetActionStatePose).isActive ==
         XR_TRUE;
}

XrResult RuntimeTest::Current(XrPath top_level, XrPath* profile) {
  auto state = Make<XrInteractionProfileState>(XR_TYPE_INTERACTION_PROFILE_STATE);
  const XrResult result = xrGetCurrentInteractionProfile(session_, top_level, &state);
  *profile = state.interactionProfile;
  return result;
}

std::string RuntimeTest::CurrentProfile(const std::string& top_level) {
  XrPath profile = XR_NULL_PATH;
  EXPECT_EQ(Current(Path(top_level), &profile), XR_SUCCESS);
  return profile == XR_NULL_PATH ? "" : Text(profile);
}

XrSpace RuntimeTest::ActionSpace(XrAction action, const std::string& subaction, const XrPosef& offset) {
  auto info = Make<XrActionSpaceCreateInfo>(XR_TYPE_ACTION_SPACE_CREATE_INFO);
  info.action = action;
  info.subactionPath = subaction.empty() ? XR_NULL_PATH : Path("/user/hand/" + subaction);
  info.poseInActionSpace = offset;
  XrSpace space = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateActionSpace(session_, &info, &space), XR_SUCCESS);
  return space;
}

XrSpace RuntimeTest::ReferenceSpace(XrReferenceSpaceType type, const XrPosef& offset) {
  auto info = Make<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  info.referenceSpaceType = type;
  info.poseInReferenceSpace = offset;
  XrSpace space = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_SUCCESS);
  return space;
}

XrTime RuntimeTest::Now() {
  PFN_xrConvertTimespecTimeToTimeKHR convert = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrConvertTimespecTimeToTimeKHR",
                                  reinterpret_cast<PFN_xrVoidFunction*>(&convert)),
            XR_SUCCESS);
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  XrTime time = 0;
  EXPECT_EQ(convert(instance_, &now, &time), XR_SUCCESS);
  return time;
}

Where RuntimeTest::Locate(XrSpace space, XrSpace base, XrTime time) {
  Where where{};
  where.velocity.type = XR_TYPE_SPACE_VELOCITY;
  where.location.type = XR_TYPE_SPACE_LOCATION;
  where.location.next = &where.velocity;
  where.result = xrLocateSpace(space, base, time == 0 ? Now() : time, &where.location);
  where.location.next = nullptr;
  return where;
}

}  // namespace omni::runtime
