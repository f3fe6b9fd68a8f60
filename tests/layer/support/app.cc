#include "tests/layer/support/app.h"

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace omni::test {
namespace {

void Must(XrResult result, const char* what) {
  if (XR_FAILED(result)) throw std::runtime_error(std::string(what) + ": " + Name(result));
}

}  // namespace

void Pause_ms(long ms) {
  const timespec t{ms / 1000, ms % 1000 * 1'000'000};
  nanosleep(&t, nullptr);
}

std::int64_t Patience_ns() {
  static const char* const seconds = std::getenv("OMNI_TEST_PATIENCE_S");
  return (seconds ? std::atoi(seconds) : 20) * std::int64_t{1'000'000'000};
}

bool Eventually(const std::function<bool()>& done) {
  const std::int64_t end = Now_ns() + Patience_ns();
  while (!done()) {
    if (Now_ns() > end) return false;
    Pause_ms(2);
  }
  return true;
}

std::string Name(XrResult result) { return "XrResult " + std::to_string(static_cast<int>(result)); }

App::App(const AppOptions& options) {
  MakeInstance(options);
  XrSystemGetInfo get_system{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  Must(xrGetSystem(instance, &get_system, &system), "xrGetSystem");
  left = Path("/user/hand/left");
  right = Path("/user/hand/right");
  MakeActions();
  XrSessionCreateInfo create_session{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, system};
  Must(xrCreateSession(instance, &create_session, &session), "xrCreateSession");
  if (options.attach) {
    for (const char* profile : options.profiles) Must(SuggestUsual(profile), profile);
    Must(Attach(), "xrAttachSessionActionSets");
  }
  if (options.begin) PollUntilFocused();
}

App::~App() {
  if (instance != XR_NULL_HANDLE) xrDestroyInstance(instance);
}

void App::MakeInstance(const AppOptions& options) {
  std::vector<const char*> extensions{"XR_MND_headless"};
  if (options.timespec_extension) extensions.push_back("XR_KHR_convert_timespec_time");
  if (options.mx_ink_extension) extensions.push_back(XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME);
  extensions.insert(extensions.end(), options.extensions.begin(), options.extensions.end());
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "%s", options.name);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
  // OMNI_TEST_APP_LAYERS=none: XR_ENABLE_API_LAYERS alone selects the layers and their order.
  const char* layers = std::getenv("OMNI_TEST_APP_LAYERS");
  const bool name_layer = options.layer && !(layers && std::strcmp(layers, "none") == 0);
  info.enabledApiLayerCount = name_layer ? 1 : 0;
  info.enabledApiLayerNames = &kLayer;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.enabledExtensionNames = extensions.data();
  Must(xrCreateInstance(&info, &instance), "xrCreateInstance");
}

XrActionSet App::MakeSet(const char* name, std::uint32_t priority) const {
  XrActionSetCreateInfo info{XR_TYPE_ACTION_SET_CREATE_INFO};
  std::snprintf(info.actionSetName, sizeof(info.actionSetName), "%s", name);
  std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "Set %s", name);
  info.priority = priority;
  XrActionSet made = XR_NULL_HANDLE;
  Must(xrCreateActionSet(instance, &info, &made), "xrCreateActionSet");
  return made;
}

XrAction App::MakeAction(XrActionSet in, const char* name, XrActionType type, bool with_hands) const {
  const XrPath hands[] = {left, right};
  XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
  std::snprintf(info.actionName, sizeof(info.actionName), "%s", name);
  std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "Action %s", name);
  info.actionType = type;
  info.countSubactionPaths = with_hands ? 2 : 0;
  info.subactionPaths = hands;
  XrAction made = XR_NULL_HANDLE;
  Must(xrCreateAction(in, &info, &made), "xrCreateAction");
  return made;
}

void App::MakeActions() {
  set = MakeSet("main", 0);
  pose = MakeAction(set, "pose", XR_ACTION_TYPE_POSE_INPUT);
  select = MakeAction(set, "select", XR_ACTION_TYPE_BOOLEAN_INPUT);
  force = MakeAction(set, "force", XR_ACTION_TYPE_FLOAT_INPUT);
  stick = MakeAction(set, "stick", XR_ACTION_TYPE_VECTOR2F_INPUT);
  squeeze = MakeAction(set, "squeeze", XR_ACTION_TYPE_BOOLEAN_INPUT);
  haptic = MakeAction(set, "haptic", XR_ACTION_TYPE_VIBRATION_OUTPUT);
  unbound = MakeAction(set, "unbound", XR_ACTION_TYPE_BOOLEAN_INPUT);
  plain = MakeAction(set, "plain", XR_ACTION_TYPE_BOOLEAN_INPUT, false);
}

XrPath App::Path(const std::string& text) const {
  XrPath path = XR_NULL_PATH;
  Must(xrStringToPath(instance, text.c_str(), &path), text.c_str());
  return path;
}

std::string App::Text(XrPath path) const {
  if (path == XR_NULL_PATH) return {};
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  Must(xrPathToString(instance, path, sizeof(text), &length, text), "xrPathToString");
  return text;
}

XrResult App::Suggest(const char* profile, const std::vector<Bound>& bindings) const {
  std::vector<XrActionSuggestedBinding> list;
  list.reserve(bindings.size());
  for (const Bound& bound : bindings) list.push_back({bound.action, Path(bound.path)});
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, Path(profile),
                                                  static_cast<std::uint32_t>(list.size()), list.data()};
  return xrSuggestInteractionProfileBindings(instance, &info);
}

XrResult App::SuggestUsual(const char* profile) const {
  if (std::strcmp(profile, kTouch) == 0)
    return Suggest(profile, {{pose, "/user/hand/left/input/grip/pose"},
                             {pose, "/user/hand/right/input/aim/pose"},
                             {select, "/user/hand/left/input/trigger/value"},
                             {select, "/user/hand/right/input/trigger/value"},
                             {plain, "/user/hand/right/input/a/click"},
                             {force, "/user/hand/left/input/trigger"},
                             {force, "/user/hand/right/input/trigger"},
                             {stick, "/user/hand/left/input/thumbstick"},
                             {stick, "/user/hand/right/input/thumbstick"},
                             {squeeze, "/user/hand/left/input/squeeze/value"},
                             {squeeze, "/user/hand/right/input/squeeze/value"},
                             {haptic, "/user/hand/left/output/haptic"},
                             {haptic, "/user/hand/right/output/haptic"}});
  if (std::strcmp(profile, kSimple) == 0)
    return Suggest(profile, {{pose, "/user/hand/left/input/grip/pose"},
                             {pose, "/user/hand/right/input/grip/pose"},
                             {select, "/user/hand/left/input/select/click"},
                             {select, "/user/hand/right/input/select/click"},
                             {haptic, "/user/hand/left/output/haptic"},
                             {haptic, "/user/hand/right/output/haptic"}});
  return Suggest(profile, {{pose, "/user/hand/right/input/tip_logitech/pose"},
                           {select, "/user/hand/right/input/tip_logitech"},
                           {force, "/user/hand/right/input/tip_logitech/force"},
                           {squeeze, "/user/hand/right/input/cluster_front_logitech/click"},
                           {haptic, "/user/hand/right/output/haptic"}});
}

XrResult App::Attach() const {
  const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set};
  return xrAttachSessionActionSets(session, &info);
}

XrResult App::Sync() const { return SyncSets({{set, XR_NULL_PATH}}); }

XrResult App::SyncSets(const std::vector<XrActiveActionSet>& sets) const {
  const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, static_cast<std::uint32_t>(sets.size()),
                               sets.data()};
  return xrSyncActions(session, &info);
}

void App::Poll() {
  for (;;) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
    if (xrPollEvent(instance, &event) != XR_SUCCESS) return;
    events.push_back(event.type);
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    XrEventDataSessionStateChanged changed;
    std::memcpy(&changed, &event, sizeof(changed));
    state = changed.state;
    if (state == XR_SESSION_STATE_READY) {
      const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
      Must(xrBeginSession(session, &info), "xrBeginSession");
    }
    if (state == XR_SESSION_STATE_STOPPING) Must(xrEndSession(session), "xrEndSession");
  }
}

void App::PollUntilFocused() {
  const std::int64_t end = Now_ns() + Patience_ns();
  while (state != XR_SESSION_STATE_FOCUSED) {
    if (Now_ns() > end) throw std::runtime_error("the session never became focused");
    Poll();
  }
}

bool App::SyncUntil(FakeService& service, const std::function<bool()>& done) {
  const std::int64_t end = Now_ns() + Patience_ns();
  for (;;) {
    service.Fill();
    Must(Sync(), "xrSyncActions");
    if (done()) return true;
    if (Now_ns() > end) return false;
    Pause_ms(5);
  }
}

bool App::WaitProfile(FakeService& service, const char* profile) {
  const std::string wanted = profile ? profile : "";
  return SyncUntil(service, [&] { return Profile(right) == wanted; });
}

std::string App::Profile(XrPath user_path) const {
  XrInteractionProfileState profile{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  Must(xrGetCurrentInteractionProfile(session, user_path, &profile), "xrGetCurrentInteractionProfile");
  return Text(profile.interactionProfile);
}

XrActionStateBoolean App::Bool(XrAction action, XrPath subaction) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
  XrActionStateBoolean out{XR_TYPE_ACTION_STATE_BOOLEAN};
  Must(xrGetActionStateBoolean(session, &info, &out), "xrGetActionStateBoolean");
  return out;
}

XrActionStateFloat App::Float(XrAction action, XrPath subaction) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
  XrActionStateFloat out{XR_TYPE_ACTION_STATE_FLOAT};
  Must(xrGetActionStateFloat(session, &info, &out), "xrGetActionStateFloat");
  return out;
}

XrActionStateVector2f App::Vector(XrAction action, XrPath subaction) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
  XrActionStateVector2f out{XR_TYPE_ACTION_STATE_VECTOR2F};
  Must(xrGetActionStateVector2f(session, &info, &out), "xrGetActionStateVector2f");
  return out;
}

bool App::PoseActive(XrAction action, XrPath subaction) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
  XrActionStatePose out{XR_TYPE_ACTION_STATE_POSE};
  Must(xrGetActionStatePose(session, &info, &out), "xrGetActionStatePose");
  return out.isActive == XR_TRUE;
}

XrSpace App::ActionSpace(XrAction action, XrPath subaction, const XrPosef& offset) const {
  const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, action, subaction, offset};
  XrSpace space = XR_NULL_HANDLE;
  Must(xrCreateActionSpace(session, &info, &space), "xrCreateActionSpace");
  return space;
}

XrSpace App::ReferenceSpace(XrReferenceSpaceType type, const XrPosef& offset) const {
  const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, offset};
  XrSpace space = XR_NULL_HANDLE;
  Must(xrCreateReferenceSpace(session, &info, &space), "xrCreateReferenceSpace");
  return space;
}

XrResult App::Vibrate(XrPath subaction, float amplitude) const {
  const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, haptic, subaction};
  const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, 20'000'000, 150.0f, amplitude};
  return xrApplyHapticFeedback(session, &info,
                               static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration)));
}

int App::CountEvents(XrStructureType type) const {
  return static_cast<int>(std::count(events.begin(), events.end(), type));
}

}  // namespace omni::test
