// omni_touch: what any application with a hand's controller does, from beginning to end. Nothing in it knows of Omni:
// the runtime's controller moves it; with the layer XR_APILAYER_OMNI_stylus loaded, the pen does.
//
//   omni_touch [--hand right|left] [--seconds S] [--name NAME]
//
// It prints the pose four times a second and every press, and answers a press with a pulse. Exit status: 0; 1 with a
// line on stderr; 2 wrong arguments.

#include <openxr/openxr.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "session/session.h"

namespace {

using example::Options;
using example::Session;

bool Ok(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  std::fprintf(stderr, "omni_touch: %s failed with XrResult %d\n", call, static_cast<int>(result));
  return false;
}

XrPath PathOf(XrInstance instance, const std::string& text) {
  XrPath path = XR_NULL_PATH;
  return Ok(xrStringToPath(instance, text.c_str(), &path), "xrStringToPath") ? path : XR_NULL_PATH;
}

// 1. An instance, with the extensions that a session needs and those that bring profiles we know.
constexpr const char* kStylusExtension = "XR_LOGITECH_mx_ink_stylus_interaction";

XrInstance CreateInstance(const Options& options, const std::vector<std::string>& offered,
                          const std::vector<const char*>& for_session, std::string* problem) {
  std::vector<const char*> names = for_session;
  if (example::Contains(offered, kStylusExtension)) names.push_back(kStylusExtension);
  return example::CreateInstance(options.name, names, problem);
}

// 2. Actions: what the user can do, in words of the application, not of a device.
struct Actions {
  XrActionSet set = XR_NULL_HANDLE;
  XrAction pose = XR_NULL_HANDLE;    // where the hand points
  XrAction select = XR_NULL_HANDLE;  // pressed or not
  XrAction force = XR_NULL_HANDLE;   // how much, 0 to 1
  XrAction pulse = XR_NULL_HANDLE;   // output
};

XrAction CreateAction(XrActionSet set, XrPath hand, XrActionType type, const char* name) {
  XrActionCreateInfo info{};
  info.type = XR_TYPE_ACTION_CREATE_INFO;
  info.actionType = type;
  info.countSubactionPaths = 1;
  info.subactionPaths = &hand;
  std::snprintf(info.actionName, sizeof(info.actionName), "%s", name);
  std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "%s", name);
  XrAction action = XR_NULL_HANDLE;
  return Ok(xrCreateAction(set, &info, &action), "xrCreateAction") ? action : XR_NULL_HANDLE;
}

bool CreateActions(XrInstance instance, XrPath hand, Actions& actions) {
  XrActionSetCreateInfo info{};
  info.type = XR_TYPE_ACTION_SET_CREATE_INFO;
  std::snprintf(info.actionSetName, sizeof(info.actionSetName), "touch");
  std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "Touch");
  if (!Ok(xrCreateActionSet(instance, &info, &actions.set), "xrCreateActionSet")) return false;
  actions.pose = CreateAction(actions.set, hand, XR_ACTION_TYPE_POSE_INPUT, "pose");
  actions.select = CreateAction(actions.set, hand, XR_ACTION_TYPE_BOOLEAN_INPUT, "select");
  actions.force = CreateAction(actions.set, hand, XR_ACTION_TYPE_FLOAT_INPUT, "force");
  actions.pulse = CreateAction(actions.set, hand, XR_ACTION_TYPE_VIBRATION_OUTPUT, "pulse");
  return actions.pose && actions.select && actions.force && actions.pulse;
}

// 3. For each device that we know, the inputs that suit our actions. The runtime chooses the profile; a boolean action
// may be bound to an analogue input, and the runtime applies a threshold.
struct Profile {
  const char* path;
  const char* pose;
  const char* select;
  const char* force;
};
constexpr Profile kStylus{"/interaction_profiles/logitech/mx_ink_stylus_logitech", "/input/tip_logitech/pose",
                          "/input/tip_logitech/force", "/input/tip_logitech/force"};
constexpr Profile kTouch{"/interaction_profiles/oculus/touch_controller", "/input/aim/pose", "/input/trigger/value",
                         "/input/trigger/value"};
constexpr Profile kSimple{"/interaction_profiles/khr/simple_controller", "/input/aim/pose", "/input/select/click",
                          "/input/select/click"};

bool Suggest(XrInstance instance, const std::string& hand, const Actions& actions, const Profile& profile) {
  const XrActionSuggestedBinding bindings[] = {{actions.pose, PathOf(instance, hand + profile.pose)},
                                               {actions.select, PathOf(instance, hand + profile.select)},
                                               {actions.force, PathOf(instance, hand + profile.force)},
                                               {actions.pulse, PathOf(instance, hand + "/output/haptic")}};
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                  PathOf(instance, profile.path), 4, bindings};
  return Ok(xrSuggestInteractionProfileBindings(instance, &info), "xrSuggestInteractionProfileBindings");
}

// 4. Spaces: the action's, which moves with the hand, and LOCAL, which stands still.
struct Spaces {
  XrSpace hand = XR_NULL_HANDLE;
  XrSpace local = XR_NULL_HANDLE;
};

bool CreateSpaces(XrSession session, const Actions& actions, XrPath hand, Spaces& spaces) {
  constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};
  const XrActionSpaceCreateInfo action{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, actions.pose, hand, kIdentity};
  const XrReferenceSpaceCreateInfo local{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL,
                                         kIdentity};
  return Ok(xrCreateActionSpace(session, &action, &spaces.hand), "xrCreateActionSpace") &&
         Ok(xrCreateReferenceSpace(session, &local, &spaces.local), "xrCreateReferenceSpace");
}

bool Attach(XrSession session, const Actions& actions) {
  const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &actions.set};
  return Ok(xrAttachSessionActionSets(session, &info), "xrAttachSessionActionSets");
}

// What happened, for the last line.
struct Counts {
  long frames = 0;
  long located = 0;
  long presses = 0;
  bool pressed = false;
  std::string profile = "none";
};

// 5. Every frame: states are sampled at xrSyncActions and stay the same until the next one.
void ReadButtons(XrSession session, const Actions& actions, XrPath hand, Counts& counts) {
  const XrActionStateGetInfo select{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, actions.select, hand};
  XrActionStateBoolean state{};
  state.type = XR_TYPE_ACTION_STATE_BOOLEAN;
  if (XR_FAILED(xrGetActionStateBoolean(session, &select, &state))) return;
  const bool pressed = state.isActive && state.currentState;
  if (pressed && !counts.pressed) {
    ++counts.presses;
    std::printf("pressed\n");
    const XrHapticActionInfo where{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, actions.pulse, hand};
    const XrHapticVibration pulse{XR_TYPE_HAPTIC_VIBRATION, nullptr, 30'000'000, XR_FREQUENCY_UNSPECIFIED, 0.5f};
    xrApplyHapticFeedback(session, &where, reinterpret_cast<const XrHapticBaseHeader*>(&pulse));
  }
  counts.pressed = pressed;
}

void ReadPose(XrSession session, const Actions& actions, const Spaces& spaces, XrPath hand, XrTime time,
              Counts& counts) {
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY, nullptr, 0, {}, {}};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity, 0, {}};
  if (XR_FAILED(xrLocateSpace(spaces.hand, spaces.local, time, &location))) return;
  if ((location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) == 0) return;
  ++counts.located;
  if (counts.frames % 22 != 0) return;
  const XrActionStateGetInfo force{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, actions.force, hand};
  XrActionStateFloat pressure{};
  pressure.type = XR_TYPE_ACTION_STATE_FLOAT;
  xrGetActionStateFloat(session, &force, &pressure);
  const XrVector3f& p = location.pose.position;
  const XrVector3f& v = velocity.linearVelocity;
  std::printf("at (%.3f, %.3f, %.3f) m, moving (%.2f, %.2f, %.2f) m/s, force %.2f%s\n", p.x, p.y, p.z, v.x, v.y, v.z,
              pressure.currentState,
              location.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT ? "" : ", not tracked");
}

std::string CurrentProfile(XrInstance instance, XrSession session, XrPath hand) {
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  char text[XR_MAX_PATH_LENGTH] = "none";
  std::uint32_t length = 0;
  if (XR_SUCCEEDED(xrGetCurrentInteractionProfile(session, hand, &state)) && state.interactionProfile != XR_NULL_PATH)
    xrPathToString(instance, state.interactionProfile, sizeof(text), &length, text);
  return text;
}

void OnEvent(const XrEventDataBuffer& event, void* profile_changed) {
  if (event.type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) *static_cast<bool*>(profile_changed) = true;
}

bool Prepare(XrInstance instance, const Session& session, const Options& options, bool stylus, Actions& actions,
             Spaces& spaces) {
  const std::string hand_path = "/user/hand/" + options.hand;
  const XrPath hand = PathOf(instance, hand_path);
  return CreateActions(instance, hand, actions) && Suggest(instance, hand_path, actions, kSimple) &&
         Suggest(instance, hand_path, actions, kTouch) && (!stylus || Suggest(instance, hand_path, actions, kStylus)) &&
         Attach(session.handle(), actions) && CreateSpaces(session.handle(), actions, hand, spaces);
}

void Loop(XrInstance instance, Session& session, const Options& options, const Actions& actions, const Spaces& spaces) {
  const XrPath hand = PathOf(instance, "/user/hand/" + options.hand);
  Counts counts;
  XrTime end = 0;
  bool leaving = false;
  while (!session.over()) {
    bool profile_changed = false;
    session.PollEvents(&OnEvent, &profile_changed);
    if (profile_changed) {
      counts.profile = CurrentProfile(instance, session.handle(), hand);
      std::printf("the %s hand holds: %s\n", options.hand.c_str(), counts.profile.c_str());
    }
    const XrTime time = session.NextFrame();
    if (time == 0 || leaving) continue;
    if (end == 0) end = time + static_cast<XrDuration>(1e9 * options.seconds);
    if (time >= end) {
      leaving = Ok(xrRequestExitSession(session.handle()), "xrRequestExitSession");  // STOPPING comes as an event
      if (!leaving) break;
    }
    ++counts.frames;
    const XrActiveActionSet active{actions.set, XR_NULL_PATH};
    const XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
    if (xrSyncActions(session.handle(), &sync) != XR_SUCCESS) continue;  // XR_SESSION_NOT_FOCUSED: no input for us
    ReadButtons(session.handle(), actions, hand, counts);
    ReadPose(session.handle(), actions, spaces, hand, time, counts);
  }
  std::printf("frames %ld, located %ld, presses %ld, profile %s\n", counts.frames, counts.located, counts.presses,
              counts.profile.c_str());
}

int Fail(const std::string& problem) {
  if (!problem.empty()) std::fprintf(stderr, "omni_touch: %s\n", problem.c_str());
  return 1;
}

int Run(const Options& options) {
  const std::vector<std::string> offered = example::AvailableExtensions();
  std::string problem;
  const std::vector<const char*> for_session = Session::Extensions(offered, &problem);
  if (for_session.empty()) return Fail(problem);
  const example::Instance instance{CreateInstance(options, offered, for_session, &problem)};
  if (instance.handle == XR_NULL_HANDLE) return Fail(problem);
  Session session(instance.handle, for_session);
  if (session.handle() == XR_NULL_HANDLE) return Fail(session.problem());
  Actions actions;
  Spaces spaces;
  if (!Prepare(instance.handle, session, options, example::Contains(offered, kStylusExtension), actions, spaces))
    return 1;
  Loop(instance.handle, session, options, actions, spaces);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.name = "omni_touch";
  if (const auto ended = example::ParseArguments(argc, argv, options)) return *ended;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  return Run(options);
}
