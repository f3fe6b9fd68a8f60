// Times OpenXR calls of an ordinary headless session, with whatever layers the environment enables, and writes
// [{"call", "ns_median", "ns_p99"}] to stdout. Percentiles are over batches of 64 calls.
//   --pen / --no-pen   wait until the right hand's pose is valid / do not
//   --count N          instead: N calls of each counted kind between markers (getppid), for a tracer
#include <time.h>
#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

void Check(XrResult result, const char* what) {
  if (XR_SUCCEEDED(result)) return;
  std::fprintf(stderr, "omni_bench_layer: %s: %d\n", what, static_cast<int>(result));
  std::exit(1);
}

struct App {
  XrInstance instance = XR_NULL_HANDLE;
  XrSession session = XR_NULL_HANDLE;
  XrSpace local = XR_NULL_HANDLE;
  XrSpace right = XR_NULL_HANDLE;
  XrSpace left = XR_NULL_HANDLE;
  XrActionSet set = XR_NULL_HANDLE;
  XrPath left_path = XR_NULL_PATH, right_path = XR_NULL_PATH;
  PFN_xrConvertTimespecTimeToTimeKHR to_time = nullptr;
};

XrTime Now(const App& app) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  XrTime time = 0;
  Check(app.to_time(app.instance, &now, &time), "xrConvertTimespecTimeToTimeKHR");
  return time;
}

XrPath Path(const App& app, const char* text) {
  XrPath path = XR_NULL_PATH;
  Check(xrStringToPath(app.instance, text, &path), text);
  return path;
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
  const char* const extensions[] = {"XR_MND_headless", "XR_KHR_convert_timespec_time"};
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::strncpy(info.applicationInfo.applicationName, "omni_bench_layer", XR_MAX_APPLICATION_NAME_SIZE - 1);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = 2;
  info.enabledExtensionNames = extensions;
  Check(xrCreateInstance(&info, &app.instance), "xrCreateInstance");
  PFN_xrVoidFunction function = nullptr;
  Check(xrGetInstanceProcAddr(app.instance, "xrConvertTimespecTimeToTimeKHR", &function), "xrGetInstanceProcAddr");
  app.to_time = reinterpret_cast<PFN_xrConvertTimespecTimeToTimeKHR>(function);
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

XrSpace ActionSpace(const App& app, XrAction action, XrPath hand) {
  XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO};
  info.action = action;
  info.subactionPath = hand;
  info.poseInActionSpace.orientation.w = 1;
  XrSpace space = XR_NULL_HANDLE;
  Check(xrCreateActionSpace(app.session, &info, &space), "xrCreateActionSpace");
  return space;
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
  XrAction action = XR_NULL_HANDLE;
  Check(xrCreateAction(app.set, &info, &action), "xrCreateAction");
  const XrActionSuggestedBinding bindings[] = {{action, Path(app, "/user/hand/left/input/grip/pose")},
                                               {action, Path(app, "/user/hand/right/input/grip/pose")}};
  XrInteractionProfileSuggestedBinding suggested{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING};
  suggested.interactionProfile = Path(app, "/interaction_profiles/oculus/touch_controller");
  suggested.countSuggestedBindings = 2;
  suggested.suggestedBindings = bindings;
  Check(xrSuggestInteractionProfileBindings(app.instance, &suggested), "xrSuggestInteractionProfileBindings");
  XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO};
  attach.countActionSets = 1;
  attach.actionSets = &app.set;
  Check(xrAttachSessionActionSets(app.session, &attach), "xrAttachSessionActionSets");
  app.left = ActionSpace(app, action, app.left_path);
  app.right = ActionSpace(app, action, app.right_path);
  XrReferenceSpaceCreateInfo local{XR_TYPE_REFERENCE_SPACE_CREATE_INFO};
  local.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  local.poseInReferenceSpace.orientation.w = 1;
  Check(xrCreateReferenceSpace(app.session, &local, &app.local), "xrCreateReferenceSpace");
}

bool RightValid(const App& app) {
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  Check(xrLocateSpace(app.right, app.local, Now(app), &location), "xrLocateSpace");
  return (location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0;
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

void Time(const char* name, const std::function<void()>& call, bool last) {
  constexpr int kBatches = 3000;
  constexpr int kPerBatch = 64;
  std::vector<double> ns;
  for (int batch = 0; batch < kBatches; ++batch) {
    const Clock::time_point begin = Clock::now();
    for (int i = 0; i < kPerBatch; ++i) call();
    ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / kPerBatch);
  }
  std::sort(ns.begin(), ns.end());
  std::printf("{\"call\": \"%s\", \"ns_median\": %.1f, \"ns_p99\": %.1f}%s\n", name, ns[ns.size() / 2],
              ns[ns.size() * 99 / 100], last ? "" : ",");
}

void Count(const std::function<void()>& call, int times) {
  for (int i = 0; i < times; ++i) call();
  syscall(SYS_getppid);
}

}  // namespace

int main(int argc, char** argv) {
  bool pen = false;
  int count = 0;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--pen") == 0) pen = true;
    if (std::strcmp(argv[i], "--count") == 0 && i + 1 < argc) count = std::atoi(argv[++i]);
  }
  App app;
  CreateInstance(app);
  CreateSession(app);
  CreateActions(app);
  for (int i = 0; i < 10; ++i) Sync(app);
  if (pen) WaitForPen(app);

  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  const XrTime time = Now(app);
  const auto locate_right = [&] { xrLocateSpace(app.right, app.local, time, &location); };
  const auto locate_left = [&] { xrLocateSpace(app.left, app.local, time, &location); };
  XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES};
  const auto pass_through = [&] { xrGetInstanceProperties(app.instance, &properties); };
  if (count > 0) {
    for (int i = 0; i < 10; ++i) {  // lazy binding and first touches
      locate_right();
      locate_left();
      pass_through();
    }
    syscall(SYS_getppid);
    Count(locate_right, count);
    Count(locate_left, count);
    Count(pass_through, count);
  } else {
    std::printf("[");
    Time("xrLocateSpace (pen)", locate_right, false);
    Time("xrLocateSpace (other hand)", locate_left, false);
    Time("xrGetInstanceProperties (pass-through)", pass_through, false);
    Time(
        "xrSyncActions", [&] { Sync(app); }, true);
    std::printf("]\n");
  }
  xrDestroyInstance(app.instance);
  return 0;
}
