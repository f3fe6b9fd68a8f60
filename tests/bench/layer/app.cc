#include "tests/bench/layer/app.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>
#include <vector>

namespace omni::bench {

namespace {

constexpr const char* kLocateSpaces = "XR_KHR_locate_spaces";

bool Available(const char* name) {
  std::uint32_t count = 0;
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr))) return false;
  std::vector<XrExtensionProperties> all(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, all.data()))) return false;
  return std::any_of(all.begin(), all.end(), [name](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

XrPath Path(const App& app, const char* text) {
  XrPath path = XR_NULL_PATH;
  Check(xrStringToPath(app.instance, text, &path), text);
  return path;
}

XrSpace ActionSpace(const App& app, XrAction action, XrPath hand) {
  XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO};
  info.action = action;
  info.subactionPath = hand;
  info.poseInActionSpace.orientation.w = 1;
  XrSpace space = XR_NULL_HANDLE;
  Check(xrCreateActionSpace(app.session, &info, &space), "xrCreateActionSpace");
  return space;
}

bool RightValid(const App& app) {
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  Check(xrLocateSpace(app.right, app.local, Now(app), &location), "xrLocateSpace");
  return (location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0;
}

}  // namespace

void Check(XrResult result, const char* what) {
  if (XR_SUCCEEDED(result)) return;
  std::fprintf(stderr, "omni_bench_layer: %s: %d\n", what, static_cast<int>(result));
  std::exit(1);
}

XrTime Now(const App& app) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  XrTime time = 0;
  Check(app.to_time(app.instance, &now, &time), "xrConvertTimespecTimeToTimeKHR");
  return time;
}

void Sync(const App& app) {
  XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
  while (xrPollEvent(app.instance, &event) == XR_SUCCESS) event = {XR_TYPE_EVENT_DATA_BUFFER};
  const XrActiveActionSet active{app.set, XR_NULL_PATH};
  XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO};
  info.countActiveActionSets = 1;
  info.activeActionSets = &active;
  Check(xrSyncActions(app.session, &info), "xrSyncActions");
}

void CreateInstance(App& app) {
  std::vector<const char*> extensions{"XR_MND_headless", "XR_KHR_convert_timespec_time"};
  if (Available(kLocateSpaces)) extensions.push_back(kLocateSpaces);
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::strncpy(info.applicationInfo.applicationName, "omni_bench_layer", XR_MAX_APPLICATION_NAME_SIZE - 1);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.enabledExtensionNames = extensions.data();
  Check(xrCreateInstance(&info, &app.instance), "xrCreateInstance");
  PFN_xrVoidFunction function = nullptr;
  Check(xrGetInstanceProcAddr(app.instance, "xrConvertTimespecTimeToTimeKHR", &function), "xrGetInstanceProcAddr");
  app.to_time = reinterpret_cast<PFN_xrConvertTimespecTimeToTimeKHR>(function);
  if (XR_FAILED(xrGetInstanceProcAddr(app.instance, "xrLocateSpacesKHR", &app.locate_spaces)))
    app.locate_spaces = nullptr;
  app.left_path = Path(app, "/user/hand/left");
  app.right_path = Path(app, "/user/hand/right");
}

void CreateSession(App& app) {
  XrSystemGetInfo system_info{XR_TYPE_SYSTEM_GET_INFO};
  system_info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  Check(xrGetSystem(app.instance, &system_info, &system), "xrGetSystem");
  XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO};
  info.systemId = system;
  Check(xrCreateSession(app.instance, &info, &app.session), "xrCreateSession");
  for (int i = 0; i < 200; ++i) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
    if (xrPollEvent(app.instance, &event) != XR_SUCCESS) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    const auto* changed = reinterpret_cast<const XrEventDataSessionStateChanged*>(&event);
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED && changed->state == XR_SESSION_STATE_READY) break;
  }
  XrSessionBeginInfo begin{XR_TYPE_SESSION_BEGIN_INFO};
  begin.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  Check(xrBeginSession(app.session, &begin), "xrBeginSession");
}

void CreateActions(App& app) {
  XrActionSetCreateInfo set_info{XR_TYPE_ACTION_SET_CREATE_INFO};
  std::strcpy(set_info.actionSetName, "bench");
  std::strcpy(set_info.localizedActionSetName, "Bench");
  Check(xrCreateActionSet(app.instance, &set_info, &app.set), "xrCreateActionSet");
  const XrPath hands[] = {app.left_path, app.right_path};
  XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
  std::strcpy(info.actionName, "pose");
  std::strcpy(info.localizedActionName, "Pose");
  info.actionType = XR_ACTION_TYPE_POSE_INPUT;
  info.countSubactionPaths = 2;
  info.subactionPaths = hands;
  Check(xrCreateAction(app.set, &info, &app.pose), "xrCreateAction");
  const XrActionSuggestedBinding bindings[] = {{app.pose, Path(app, "/user/hand/left/input/grip/pose")},
                                               {app.pose, Path(app, "/user/hand/right/input/grip/pose")}};
  XrInteractionProfileSuggestedBinding suggested{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING};
  suggested.interactionProfile = Path(app, "/interaction_profiles/oculus/touch_controller");
  suggested.countSuggestedBindings = 2;
  suggested.suggestedBindings = bindings;
  Check(xrSuggestInteractionProfileBindings(app.instance, &suggested), "xrSuggestInteractionProfileBindings");
  XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO};
  attach.countActionSets = 1;
  attach.actionSets = &app.set;
  Check(xrAttachSessionActionSets(app.session, &attach), "xrAttachSessionActionSets");
  app.left = ActionSpace(app, app.pose, app.left_path);
  app.right = ActionSpace(app, app.pose, app.right_path);
  XrReferenceSpaceCreateInfo local{XR_TYPE_REFERENCE_SPACE_CREATE_INFO};
  local.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  local.poseInReferenceSpace.orientation.w = 1;
  Check(xrCreateReferenceSpace(app.session, &local, &app.local), "xrCreateReferenceSpace");
}

void WaitForPen(const App& app) {
  for (int i = 0; i < 1000; ++i) {
    Sync(app);
    if (RightValid(app)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::fprintf(stderr, "omni_bench_layer: the pen's pose did not become valid in 10 s\n");
  std::exit(1);
}

}  // namespace omni::bench
