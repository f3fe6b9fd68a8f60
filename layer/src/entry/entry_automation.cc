// XR_EXT_conformance_automation for the pen's hand, in test mode (OMNI_TEST_MODE=1). Other hands are the runtime's:
// their calls go on to it, if it has the extension.
#include <algorithm>
#include <cmath>
#include <string>

#include "layer/src/entry/guarded.h"
#include "layer/src/entry/own_extensions.h"
#include "layer/src/spaces/locate.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {

// A call that concerns the pen's hand, or is to be passed on.
struct Target {
  std::shared_ptr<Instance> instance;
  std::shared_ptr<Session> session;
  TestDevice* device = nullptr;  // null: another hand, or no test mode
  Hand hand = Hand::kRight;
};

Target Find(XrSession session, XrPath top_level) {
  Target t;
  t.instance = Registry::Get().FindOwner(session);
  t.session = t.instance ? t.instance->records.sessions.Find(session) : nullptr;
  if (!t.session) return t;
  t.hand = t.instance->link.choice().hand;
  if (top_level == t.instance->runtime.hand_paths[static_cast<std::size_t>(t.hand)]) t.device = t.instance->link.test();
  return t;
}

template <class Function, class... Arguments>
XrResult PassOn(const Target& target, const char* name, Arguments... arguments) {
  if (!target.instance) return XR_ERROR_HANDLE_INVALID;
  PFN_xrVoidFunction below = nullptr;
  const XrResult found =
      target.instance->runtime.next.GetInstanceProcAddr(target.instance->runtime.handle, name, &below);
  if (XR_FAILED(found) || !below) return target.session ? XR_ERROR_FUNCTION_UNSUPPORTED : XR_ERROR_HANDLE_INVALID;
  return reinterpret_cast<Function>(below)(arguments...);
}

const Profile* ProfileOf(const Target& t) {
  const std::string path = t.device->inputs().profile;
  const auto& all = t.instance->profiles;
  const auto found = std::find_if(all.begin(), all.end(), [&](const Profile& p) { return p.path == path; });
  return found == all.end() ? nullptr : &*found;
}

// "/input/trigger/value" of the full path; empty if the path is another hand's. `result`: why.
std::string LocalPath(const Target& t, XrPath source, XrResult* result) {
  const std::string full = t.instance->runtime.PathText(source);
  const std::string user(UserPath(t.hand));
  *result = full.empty() ? XR_ERROR_PATH_INVALID : XR_ERROR_PATH_UNSUPPORTED;
  return full.rfind(user + "/", 0) == 0 ? full.substr(user.size()) : std::string();
}

const Component* FindScalar(const Profile* profile, Hand hand, const std::string& path) {
  if (!profile) return nullptr;
  for (const Component& c : profile->components)
    if (c.IsOnHand(hand) && c.path == path) return &c;
  return nullptr;
}

XrResult SetScalar(const Target& t, XrPath source, float value) {
  if (!std::isfinite(value)) return XR_ERROR_VALIDATION_FAILURE;
  XrResult result = XR_SUCCESS;
  const std::string path = LocalPath(t, source, &result);
  if (path.empty() || !FindScalar(ProfileOf(t), t.hand, path)) return result;
  t.device->SetValue(path, std::clamp(value, -1.0f, 1.0f));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL SetActive(XrSession session, XrPath profile, XrPath top_level, XrBool32 active) {
  return Guarded([&] {
    const Target t = Find(session, top_level);
    if (!t.device) {
      const XrResult below =
          PassOn<PFN_xrSetInputDeviceActiveEXT>(t, "xrSetInputDeviceActiveEXT", session, profile, top_level, active);
      // A hand that has no test device is inactive already.
      return below == XR_ERROR_FUNCTION_UNSUPPORTED && !active ? XR_SUCCESS : below;
    }
    const std::string path = t.instance->runtime.PathText(profile);
    if (path.empty()) return XR_ERROR_PATH_INVALID;
    const auto& all = t.instance->profiles;
    if (std::none_of(all.begin(), all.end(), [&](const Profile& p) { return p.path == path; }))
      return XR_ERROR_PATH_UNSUPPORTED;
    t.device->SetActive(path, active != XR_FALSE);
    return XR_SUCCESS;
  });
}

XRAPI_ATTR XrResult XRAPI_CALL SetBool(XrSession session, XrPath top_level, XrPath source, XrBool32 state) {
  return Guarded([&] {
    const Target t = Find(session, top_level);
    if (t.device) return SetScalar(t, source, state ? 1.0f : 0.0f);
    return PassOn<PFN_xrSetInputDeviceStateBoolEXT>(t, "xrSetInputDeviceStateBoolEXT", session, top_level, source,
                                                    state);
  });
}

XRAPI_ATTR XrResult XRAPI_CALL SetFloat(XrSession session, XrPath top_level, XrPath source, float state) {
  return Guarded([&] {
    const Target t = Find(session, top_level);
    if (t.device) return SetScalar(t, source, state);
    return PassOn<PFN_xrSetInputDeviceStateFloatEXT>(t, "xrSetInputDeviceStateFloatEXT", session, top_level, source,
                                                     state);
  });
}

XRAPI_ATTR XrResult XRAPI_CALL SetVector2f(XrSession session, XrPath top_level, XrPath source, XrVector2f state) {
  return Guarded([&] {
    const Target t = Find(session, top_level);
    if (!t.device)
      return PassOn<PFN_xrSetInputDeviceStateVector2fEXT>(t, "xrSetInputDeviceStateVector2fEXT", session, top_level,
                                                          source, state);
    if (!std::isfinite(state.x) || !std::isfinite(state.y)) return XR_ERROR_VALIDATION_FAILURE;
    XrResult result = XR_SUCCESS;
    const std::string path = LocalPath(t, source, &result);
    const Profile* profile = ProfileOf(t);
    const bool known =
        !path.empty() && FindScalar(profile, t.hand, path + "/x") && FindScalar(profile, t.hand, path + "/y");
    if (!known) return result;
    t.device->SetValue(path + "/x", std::clamp(state.x, -1.0f, 1.0f));
    t.device->SetValue(path + "/y", std::clamp(state.y, -1.0f, 1.0f));
    return XR_SUCCESS;
  });
}

// The tool such that this pose of the profile is at `pose` in `space`, now:
//   X_BT = inverse(X_LO) X_L_space X_space_P inverse(X_TP)
XrResult PlaceTool(const Target& t, const PoseComponent& component, XrSpace space, const XrPosef& pose) {
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  const XrTime now = t.instance->clock.ToXr(base::MonotonicNow_ns());
  const BasePose base_pose = t.session->base_pose.At(now);
  const XrResult result =
      t.instance->locator.LocateSpace(space, t.session->AnchorSpace(base_pose.space), now, &location);
  if (XR_FAILED(result)) return result;
  if ((location.locationFlags & kValid) != kValid) return XR_ERROR_RUNTIME_FAILURE;
  const Pose X_LP = Compose(FromXr(location.pose), FromXr(pose));
  t.device->SetPose(Compose(Compose(Inverse(base_pose.X_LO), X_LP), Inverse(component.X_TP)));
  return XR_SUCCESS;
}

XRAPI_ATTR XrResult XRAPI_CALL SetLocation(XrSession session, XrPath top_level, XrPath source, XrSpace space,
                                           XrPosef pose) {
  return Guarded([&] {
    const Target t = Find(session, top_level);
    if (!t.device)
      return PassOn<PFN_xrSetInputDeviceLocationEXT>(t, "xrSetInputDeviceLocationEXT", session, top_level, source,
                                                     space, pose);
    XrResult result = XR_SUCCESS;
    const std::string path = LocalPath(t, source, &result);
    const Profile* profile = ProfileOf(t);
    if (path.empty() || !profile) return result;
    for (const PoseComponent& component : profile->poses)
      if (component.path == path) return PlaceTool(t, component, space, pose);
    return result;
  });
}

}  // namespace

const std::vector<OwnFunction>& AutomationFunctions() {
  static const std::vector<OwnFunction> all{
      {"xrSetInputDeviceActiveEXT", XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, Erase(&SetActive)},
      {"xrSetInputDeviceStateBoolEXT", XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, Erase(&SetBool)},
      {"xrSetInputDeviceStateFloatEXT", XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, Erase(&SetFloat)},
      {"xrSetInputDeviceStateVector2fEXT", XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, Erase(&SetVector2f)},
      {"xrSetInputDeviceLocationEXT", XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, Erase(&SetLocation)},
  };
  return all;
}

}  // namespace omni::layer
