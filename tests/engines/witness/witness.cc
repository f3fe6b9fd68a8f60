// A layer that writes down what an OpenXR application is given: frames, profiles, poses, states, vibrations, as JSON
// lines in the file that OMNI_WITNESS_FILE names. scripts/engines loads it above ours and compares the lines with the
// twin's truth. Without the variable it only passes calls on. Poses are located once more in STAGE, whatever space the
// application uses.
#include <time.h>

#include <cinttypes>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "layer/src/entry/loader_interface.h"

#define XR_USE_TIMESPEC
#include <openxr/openxr_platform.h>

namespace omni::witness {
namespace {

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};
constexpr float kFloatStep = 0.02f;  // a smaller change of a float is not worth a line

struct ActionSpace {
  XrAction action;
  XrPath hand;
};

struct Input {
  XrAction action;
  XrPath hand;
  bool operator<(const Input& other) const {
    return action != other.action ? action < other.action : hand < other.hand;
  }
};

struct Last {
  bool active;
  float value;
};

// One instance at a time, as every application has it.
struct Witness {
  std::mutex mutex;
  std::FILE* file = nullptr;
  XrInstance instance = XR_NULL_HANDLE;
  PFN_xrGetInstanceProcAddr next = nullptr;
  PFN_xrConvertTimeToTimespecTimeKHR to_timespec = nullptr;
  XrSpace stage = XR_NULL_HANDLE;
  std::map<XrAction, std::string> actions;
  std::map<XrSpace, ActionSpace> spaces;
  std::map<Input, Last> inputs;
};
Witness& witness() {
  static Witness* const only = new Witness;  // never freed: calls may come while the process ends
  return *only;
}

long long Now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1'000'000'000LL * now.tv_sec + now.tv_nsec;
}

template <class Function>
Function Below(const char* name) {
  PFN_xrVoidFunction function = nullptr;
  const Witness& w = witness();
  return w.next && XR_SUCCEEDED(w.next(w.instance, name, &function)) ? reinterpret_cast<Function>(function) : nullptr;
}
#define OMNI_BELOW(name) Below<PFN_##name>(#name)

// One line: {"what": WHAT, "t": now, ...}; `rest` is the text of the other members.
__attribute__((format(printf, 2, 3))) void Line(const char* what, const char* rest, ...) {
  Witness& w = witness();
  if (!w.file) return;
  char text[1024];
  va_list arguments;
  va_start(arguments, rest);
  std::vsnprintf(text, sizeof(text), rest, arguments);
  va_end(arguments);
  std::fprintf(w.file, "{\"what\": \"%s\", \"t\": %lld%s%s}\n", what, Now_ns(), *text ? ", " : "", text);
  std::fflush(w.file);  // programs are also ended by a signal
}

std::string PathText(XrPath path) {
  const auto to_string = OMNI_BELOW(xrPathToString);
  char text[XR_MAX_PATH_LENGTH] = "";
  uint32_t length = 0;
  if (path == XR_NULL_PATH || !to_string || XR_FAILED(to_string(witness().instance, path, sizeof(text), &length, text)))
    return "";
  return text;
}

std::string HandText(XrPath path) {
  const std::string text = PathText(path);
  const std::string_view folder = "/user/hand/";
  return text.rfind(folder, 0) == 0 ? text.substr(folder.size()) : text;
}

std::string ActionText(XrAction action) {
  const auto found = witness().actions.find(action);
  return found == witness().actions.end() ? "" : found->second;
}

XrResult CreateSession(XrInstance instance, const XrSessionCreateInfo* info, XrSession* session) {
  const XrResult result = OMNI_BELOW(xrCreateSession)(instance, info, session);
  const std::lock_guard lock(witness().mutex);
  Line("session", "\"result\": %d, \"graphics\": %s", result, info && info->next ? "true" : "false");
  if (XR_FAILED(result)) return result;
  const XrReferenceSpaceCreateInfo stage{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_STAGE,
                                         kIdentity};
  if (XR_FAILED(OMNI_BELOW(xrCreateReferenceSpace)(*session, &stage, &witness().stage)))
    witness().stage = XR_NULL_HANDLE;
  return result;
}

XrResult CreateAction(XrActionSet set, const XrActionCreateInfo* info, XrAction* action) {
  const XrResult result = OMNI_BELOW(xrCreateAction)(set, info, action);
  const std::lock_guard lock(witness().mutex);
  if (XR_SUCCEEDED(result)) witness().actions[*action] = info->actionName;
  return result;
}

XrResult CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  const XrResult result = OMNI_BELOW(xrCreateActionSpace)(session, info, space);
  const std::lock_guard lock(witness().mutex);
  if (XR_SUCCEEDED(result)) witness().spaces[*space] = {info->action, info->subactionPath};
  return result;
}

void Profiles(XrSession session) {
  for (const char* const hand : {"/user/hand/left", "/user/hand/right"}) {
    XrPath path = XR_NULL_PATH;
    XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
    if (XR_FAILED(OMNI_BELOW(xrStringToPath)(witness().instance, hand, &path)) ||
        XR_FAILED(OMNI_BELOW(xrGetCurrentInteractionProfile)(session, path, &state)))
      continue;
    Line("profile", "\"hand\": \"%s\", \"profile\": \"%s\"", HandText(path).c_str(),
         PathText(state.interactionProfile).c_str());
  }
}

XrResult PollEvent(XrInstance instance, XrEventDataBuffer* buffer) {
  const XrResult result = OMNI_BELOW(xrPollEvent)(instance, buffer);
  if (result != XR_SUCCESS) return result;
  const std::lock_guard lock(witness().mutex);
  if (buffer->type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) {
    Profiles(reinterpret_cast<const XrEventDataInteractionProfileChanged*>(buffer)->session);
  } else if (buffer->type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
    Line("state", "\"state\": %d", reinterpret_cast<const XrEventDataSessionStateChanged*>(buffer)->state);
  }
  return result;
}

XrResult EndFrame(XrSession session, const XrFrameEndInfo* info) {
  const XrResult result = OMNI_BELOW(xrEndFrame)(session, info);
  const std::lock_guard lock(witness().mutex);
  Line("frame", "\"result\": %d, \"layers\": %u", result, info ? info->layerCount : 0);
  return result;
}

XrResult SyncActions(XrSession session, const XrActionsSyncInfo* info) {
  const XrResult result = OMNI_BELOW(xrSyncActions)(session, info);
  const std::lock_guard lock(witness().mutex);
  Line("sync", "\"result\": %d", result);
  return result;
}

// A time of the runtime on CLOCK_MONOTONIC; 0: the runtime cannot say.
long long Monotonic_ns(XrTime time) {
  timespec converted{};
  const Witness& w = witness();
  if (!w.to_timespec || XR_FAILED(w.to_timespec(w.instance, time, &converted))) return 0;
  return 1'000'000'000LL * converted.tv_sec + converted.tv_nsec;
}

XrResult LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  const auto locate = OMNI_BELOW(xrLocateSpace);
  const XrResult result = locate(space, base, time, location);
  const std::lock_guard lock(witness().mutex);
  const auto found = witness().spaces.find(space);
  if (XR_FAILED(result) || found == witness().spaces.end() || witness().stage == XR_NULL_HANDLE) return result;
  XrSpaceLocation stage{XR_TYPE_SPACE_LOCATION, nullptr, 0, kIdentity};
  if (XR_FAILED(locate(space, witness().stage, time, &stage))) return result;
  const XrVector3f& p = stage.pose.position;
  const XrQuaternionf& q = stage.pose.orientation;
  Line("pose",
       "\"action\": \"%s\", \"hand\": \"%s\", \"for\": %lld, \"flags\": %" PRIu64 ", \"stage_flags\": %" PRIu64
       ", \"p\": [%.9g, %.9g, %.9g], \"q\": [%.9g, %.9g, %.9g, %.9g]",
       ActionText(found->second.action).c_str(), HandText(found->second.hand).c_str(), Monotonic_ns(time),
       location->locationFlags, stage.locationFlags, p.x, p.y, p.z, q.w, q.x, q.y, q.z);
  return result;
}

void RecordInput(const char* what, const XrActionStateGetInfo* info, bool active, float value, float step) {
  const std::lock_guard lock(witness().mutex);
  const auto [at, first] = witness().inputs.try_emplace({info->action, info->subactionPath}, Last{false, 0});
  if (!first && at->second.active == active && std::fabs(at->second.value - value) < step) return;
  at->second = {active, value};
  Line(what, "\"action\": \"%s\", \"hand\": \"%s\", \"active\": %s, \"value\": %.4g", ActionText(info->action).c_str(),
       HandText(info->subactionPath).c_str(), active ? "true" : "false", static_cast<double>(value));
}

XrResult GetActionStateBoolean(XrSession session, const XrActionStateGetInfo* info, XrActionStateBoolean* state) {
  const XrResult result = OMNI_BELOW(xrGetActionStateBoolean)(session, info, state);
  if (XR_SUCCEEDED(result)) RecordInput("bool", info, state->isActive, state->currentState ? 1 : 0, 1);
  return result;
}

XrResult GetActionStateFloat(XrSession session, const XrActionStateGetInfo* info, XrActionStateFloat* state) {
  const XrResult result = OMNI_BELOW(xrGetActionStateFloat)(session, info, state);
  if (XR_SUCCEEDED(result)) RecordInput("float", info, state->isActive, state->currentState, kFloatStep);
  return result;
}

XrResult GetActionStatePose(XrSession session, const XrActionStateGetInfo* info, XrActionStatePose* state) {
  const XrResult result = OMNI_BELOW(xrGetActionStatePose)(session, info, state);
  if (XR_SUCCEEDED(result)) RecordInput("active", info, state->isActive, 0, 1);
  return result;
}

XrResult ApplyHapticFeedback(XrSession session, const XrHapticActionInfo* info, const XrHapticBaseHeader* haptic) {
  const XrResult result = OMNI_BELOW(xrApplyHapticFeedback)(session, info, haptic);
  const std::lock_guard lock(witness().mutex);
  Line("haptic", "\"action\": \"%s\", \"hand\": \"%s\", \"result\": %d", ActionText(info->action).c_str(),
       HandText(info->subactionPath).c_str(), result);
  return result;
}

XrResult DestroyInstance(XrInstance instance) {
  const auto destroy = OMNI_BELOW(xrDestroyInstance);
  const std::lock_guard lock(witness().mutex);
  Line("end", "%s", "");
  return destroy(instance);
}

struct Wrapped {
  const char* name;
  PFN_xrVoidFunction function;
};
#define OMNI_WRAPPED(name) \
  { "xr" #name, reinterpret_cast<PFN_xrVoidFunction>(&(name)) }
const Wrapped kWrapped[] = {
    OMNI_WRAPPED(CreateSession),
    OMNI_WRAPPED(CreateAction),
    OMNI_WRAPPED(CreateActionSpace),
    OMNI_WRAPPED(PollEvent),
    OMNI_WRAPPED(EndFrame),
    OMNI_WRAPPED(SyncActions),
    OMNI_WRAPPED(LocateSpace),
    OMNI_WRAPPED(GetActionStateFloat),
    OMNI_WRAPPED(GetActionStateBoolean),
    OMNI_WRAPPED(GetActionStatePose),
    OMNI_WRAPPED(DestroyInstance),
    OMNI_WRAPPED(ApplyHapticFeedback),
};

XrResult GetInstanceProcAddr(XrInstance instance, const char* name, PFN_xrVoidFunction* function) {
  const Witness& w = witness();
  if (!w.next) return XR_ERROR_HANDLE_INVALID;
  const XrResult result = w.next(instance, name, function);
  if (XR_FAILED(result) || !w.file) return result;
  for (const Wrapped& wrapped : kWrapped)
    if (std::strcmp(wrapped.name, name) == 0) *function = wrapped.function;
  return result;
}

// The application's own request, with the extension that converts the runtime's time.
XrResult CreateBelow(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo& below,
                     PFN_xrCreateApiLayerInstance create, XrInstance* instance) {
  std::vector<const char*> names(info->enabledExtensionNames,
                                 info->enabledExtensionNames + info->enabledExtensionCount);
  for (const char* const name : names)
    if (std::strcmp(name, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME) == 0) return create(info, &below, instance);
  names.push_back(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  XrInstanceCreateInfo more = *info;
  more.enabledExtensionCount = static_cast<uint32_t>(names.size());
  more.enabledExtensionNames = names.data();
  return create(&more, &below, instance);
}

void Introduce(const XrInstanceCreateInfo& info) {
  Witness& w = witness();
  w.to_timespec = OMNI_BELOW(xrConvertTimeToTimespecTimeKHR);
  XrInstanceProperties properties{XR_TYPE_INSTANCE_PROPERTIES, nullptr, 0, ""};
  OMNI_BELOW(xrGetInstanceProperties)(w.instance, &properties);
  std::string runtime = properties.runtimeName;
  for (char& letter : runtime)
    if (letter == '"' || letter == '\\') letter = '\'';
  Line("instance", "\"application\": \"%s\", \"engine\": \"%s\", \"api\": \"%d.%d\", \"runtime\": \"%s\"",
       info.applicationInfo.applicationName, info.applicationInfo.engineName,
       static_cast<int>(XR_VERSION_MAJOR(info.applicationInfo.apiVersion)),
       static_cast<int>(XR_VERSION_MINOR(info.applicationInfo.apiVersion)), runtime.c_str());
}

XrResult CreateApiLayerInstance(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo* layer_info,
                                XrInstance* instance) {
  Witness& w = witness();
  const XrApiLayerNextInfo* const next = layer_info->nextInfo;
  XrApiLayerCreateInfo below = *layer_info;
  below.nextInfo = next->next;
  const XrResult result = CreateBelow(info, below, next->nextCreateApiLayerInstance, instance);
  if (XR_FAILED(result)) return result;
  const std::lock_guard lock(w.mutex);
  w.next = next->nextGetInstanceProcAddr;
  w.instance = *instance;
  const char* const path = std::getenv("OMNI_WITNESS_FILE");
  if (!w.file && path) w.file = std::fopen(path, "w");
  if (w.file) Introduce(*info);
  return result;
}

}  // namespace
}  // namespace omni::witness

extern "C" XRAPI_ATTR __attribute__((visibility("default"))) XrResult XRAPI_CALL
xrNegotiateLoaderApiLayerInterface(const XrNegotiateLoaderInfo*, const char*, XrNegotiateApiLayerRequest* request) {
  request->layerInterfaceVersion = kLoaderApiLayerInterfaceVersion;
  request->layerApiVersion = XR_MAKE_VERSION(1, 1, 0);
  request->getInstanceProcAddr = &omni::witness::GetInstanceProcAddr;
  request->createApiLayerInstance = &omni::witness::CreateApiLayerInstance;
  return XR_SUCCESS;
}
