#include "tests/layer/mini_loader/chain_app.h"

#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

void Need(XrResult result, const char* what) {
  if (XR_FAILED(result)) throw std::runtime_error(std::string(what) + ": " + Name(result));
}

}  // namespace

XrInstanceCreateInfo InstanceInfo(const ChainOptions& options) {
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "chain test");
  info.applicationInfo.apiVersion = options.api_version;
  info.enabledExtensionCount = static_cast<std::uint32_t>(options.extensions.size());
  info.enabledExtensionNames = options.extensions.data();
  return info;
}

ChainApp::ChainApp(const MiniLoader& loader, const ChainOptions& options) {
  Need(loader.CreateInstance(InstanceInfo(options), &instance), "xrCreateInstance");
  f = loader.Load(instance);
  const XrSystemGetInfo get_system{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  Need(f.GetSystem(instance, &get_system, &system), "xrGetSystem");
  left = Path("/user/hand/left");
  right = Path("/user/hand/right");
  XrActionSetCreateInfo info{XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, "main", "Main", 0};
  Need(f.CreateActionSet(instance, &info, &set), "xrCreateActionSet");
  pose = MakeAction("pose", XR_ACTION_TYPE_POSE_INPUT);
  force = MakeAction("force", XR_ACTION_TYPE_FLOAT_INPUT);
  haptic = MakeAction("haptic", XR_ACTION_TYPE_VIBRATION_OUTPUT);
  const XrSessionCreateInfo create{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, system};
  Need(f.CreateSession(instance, &create, &session), "xrCreateSession");
  if (options.begin) Begin();
}

ChainApp::~ChainApp() {
  if (instance != XR_NULL_HANDLE && f.DestroyInstance) f.DestroyInstance(instance);
}

XrAction ChainApp::MakeAction(const char* name, XrActionType type) const {
  const XrPath hands[] = {left, right};
  XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO, nullptr, "", type, 2, hands, ""};
  std::snprintf(info.actionName, sizeof(info.actionName), "%s", name);
  std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "Action %s", name);
  XrAction made = XR_NULL_HANDLE;
  Need(f.CreateAction(set, &info, &made), "xrCreateAction");
  return made;
}

void ChainApp::Begin() {
  Need(Suggest(kTouch, {{pose, Path("/user/hand/left/input/aim/pose")},
                        {pose, Path("/user/hand/right/input/aim/pose")},
                        {force, Path("/user/hand/left/input/trigger/value")},
                        {force, Path("/user/hand/right/input/trigger/value")},
                        {haptic, Path("/user/hand/left/output/haptic")},
                        {haptic, Path("/user/hand/right/output/haptic")}}),
       "xrSuggestInteractionProfileBindings");
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set};
  Need(f.AttachSessionActionSets(session, &attach), "xrAttachSessionActionSets");
  const std::int64_t end = Now_ns() + Patience_ns();
  while (state != XR_SESSION_STATE_FOCUSED) {
    if (Now_ns() > end) throw std::runtime_error("the session never became focused");
    Poll();
  }
}

XrPath ChainApp::Path(const std::string& text) const {
  XrPath path = XR_NULL_PATH;
  Need(f.StringToPath(instance, text.c_str(), &path), text.c_str());
  return path;
}

std::string ChainApp::Text(XrPath path) const {
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  if (path == XR_NULL_PATH) return {};
  Need(f.PathToString(instance, path, sizeof(text), &length, text), "xrPathToString");
  return text;
}

XrResult ChainApp::Suggest(const char* profile, const std::vector<XrActionSuggestedBinding>& bindings) const {
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, Path(profile),
                                                  static_cast<std::uint32_t>(bindings.size()), bindings.data()};
  return f.SuggestInteractionProfileBindings(instance, &info);
}

XrResult ChainApp::Sync() const {
  const XrActiveActionSet active{set, XR_NULL_PATH};
  const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
  return f.SyncActions(session, &info);
}

void ChainApp::Poll() {
  for (;;) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
    if (f.PollEvent(instance, &event) != XR_SUCCESS) return;
    events.push_back(event.type);
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    XrEventDataSessionStateChanged changed;
    std::memcpy(&changed, &event, sizeof(changed));
    state = changed.state;
    if (state != XR_SESSION_STATE_READY) continue;
    const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    Need(f.BeginSession(session, &info), "xrBeginSession");
  }
}

std::string ChainApp::Profile(XrPath hand) const {
  XrInteractionProfileState profile{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  Need(f.GetCurrentInteractionProfile(session, hand, &profile), "xrGetCurrentInteractionProfile");
  return Text(profile.interactionProfile);
}

float ChainApp::Force(XrPath hand) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, force, hand};
  XrActionStateFloat out{XR_TYPE_ACTION_STATE_FLOAT, nullptr, 0, XR_FALSE, 0, XR_FALSE};
  Need(f.GetActionStateFloat(session, &info, &out), "xrGetActionStateFloat");
  return out.currentState;
}

XrSpaceLocation ChainApp::Locate(XrSpace space, XrSpace base, XrTime time) const {
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  Need(f.LocateSpace(space, base, time, &location), "xrLocateSpace");
  return location;
}

XrSpace ChainApp::ActionSpace(XrPath hand) const {
  const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, pose, hand, {{0, 0, 0, 1}, {0, 0, 0}}};
  XrSpace space = XR_NULL_HANDLE;
  Need(f.CreateActionSpace(session, &info, &space), "xrCreateActionSpace");
  return space;
}

XrSpace ChainApp::Local() const {
  const XrReferenceSpaceCreateInfo info{
      XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
  XrSpace space = XR_NULL_HANDLE;
  Need(f.CreateReferenceSpace(session, &info, &space), "xrCreateReferenceSpace");
  return space;
}

bool ChainApp::WaitProfile(FakeService& service, const std::string& profile) const {
  const std::int64_t end = Now_ns() + Patience_ns();
  while (Now_ns() < end) {
    service.Fill();
    Need(Sync(), "xrSyncActions");
    if (Profile(right) == profile) return true;
    Pause_ms(2);
  }
  return false;
}

}  // namespace omni::test
