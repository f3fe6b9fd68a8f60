#include "session/session.h"

#include <time.h>

#define XR_USE_TIMESPEC
#include <openxr/openxr_platform.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace example {
namespace {

constexpr const char* kUsage = "usage: %s [--hand right|left] [--seconds S] [--name NAME]%s\n";

// Empty: accepted.
std::string Take(const std::string& key, const char* value, Options& options) {
  if (key != "--hand" && key != "--name" && key != "--seconds") return "there is no option '" + key + "'";
  if (value == nullptr) return key + ": its value is missing";
  if (key == "--name") {
    options.name = value;
  } else if (key == "--hand") {
    options.hand = value;
    if (options.hand != "right" && options.hand != "left")
      return "--hand: '" + options.hand + "' must be right or left";
  } else {
    char* end = nullptr;
    options.seconds = std::strtod(value, &end);
    if (end == value || *end != '\0' || !(options.seconds > 0))
      return "--seconds: '" + std::string(value) + "' must be a number of seconds above 0";
  }
  return {};
}

constexpr long kFramePeriod_ns = 11'111'111;  // of an application without graphics: no runtime paces it

void* FunctionOf(XrInstance instance, const char* name) {
  PFN_xrVoidFunction function = nullptr;
  return XR_SUCCEEDED(xrGetInstanceProcAddr(instance, name, &function)) ? reinterpret_cast<void*>(function) : nullptr;
}

}  // namespace

std::optional<int> ParseArguments(int argc, char** argv, Options& options) {
  const std::string program = options.name;
  for (int i = 1; i < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--help" || key == "-h") {
      std::printf(kUsage, program.c_str(), "");
      return 0;
    }
    const std::string problem = Take(key, i + 1 < argc ? argv[i + 1] : nullptr, options);
    if (problem.empty()) continue;
    std::fprintf(stderr, kUsage, program.c_str(), ("; " + problem).c_str());
    return 2;
  }
  return std::nullopt;
}

std::vector<std::string> AvailableExtensions() {
  std::uint32_t count = 0;
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr))) return {};
  std::vector<XrExtensionProperties> properties(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, properties.data()))) return {};
  std::vector<std::string> names;
  for (const XrExtensionProperties& extension : properties) names.emplace_back(extension.extensionName);
  return names;
}

bool Contains(const std::vector<std::string>& names, const char* name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

XrInstance CreateInstance(const std::string& name, const std::vector<const char*>& extensions, std::string* problem) {
  XrInstanceCreateInfo info{};
  info.type = XR_TYPE_INSTANCE_CREATE_INFO;
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "%s", name.c_str());
  info.applicationInfo.applicationVersion = 1;
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.enabledExtensionNames = extensions.data();
  XrInstance instance = XR_NULL_HANDLE;
  const XrResult result = xrCreateInstance(&info, &instance);
  if (XR_SUCCEEDED(result)) return instance;
  *problem = "xrCreateInstance: XrResult " + std::to_string(result) + ": is a runtime installed?";
  return XR_NULL_HANDLE;
}

std::vector<const char*> Session::Extensions(const std::vector<std::string>& offered, std::string* problem) {
  if (offered.empty()) {
    *problem = "no OpenXR runtime answers: is one installed, or XR_RUNTIME_JSON set?";
  } else if (Contains(offered, XR_MND_HEADLESS_EXTENSION_NAME) &&
             Contains(offered, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME)) {
    return {XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
  } else if (VulkanExtension() == nullptr) {
    *problem = "the runtime offers no XR_MND_headless, and this program was built without Vulkan (libvulkan-dev)";
  } else if (Contains(offered, VulkanExtension())) {
    return {VulkanExtension()};
  } else {
    *problem = "the runtime offers neither XR_MND_headless nor XR_KHR_vulkan_enable2";
  }
  return {};
}

Session::Session(XrInstance instance, const std::vector<const char*>& extensions) : instance_(instance) {
  headless_ = std::strcmp(extensions.front(), XR_MND_HEADLESS_EXTENSION_NAME) == 0;
  if (headless_)
    to_time_ =
        reinterpret_cast<PFN_xrConvertTimespecTimeToTimeKHR>(FunctionOf(instance, "xrConvertTimespecTimeToTimeKHR"));
  XrSystemGetInfo wanted{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, XR_NULL_SYSTEM_ID};
  XrResult result = xrGetSystem(instance, &wanted, &info.systemId);
  if (XR_FAILED(result)) {
    problem_ = "xrGetSystem: XrResult " + std::to_string(result) + ": is a headset connected?";
    return;
  }
  if (!headless_) {
    info.next = CreateVulkan(info.systemId);
    if (info.next == nullptr) return;
  }
  result = xrCreateSession(instance, &info, &session_);
  if (XR_FAILED(result)) {
    session_ = XR_NULL_HANDLE;
    problem_ = "xrCreateSession: XrResult " + std::to_string(result);
  }
}

void Session::PollEvents(void (*other)(const XrEventDataBuffer&, void*), void* user) {
  for (;;) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
    if (xrPollEvent(instance_, &event) != XR_SUCCESS) return;  // XR_EVENT_UNAVAILABLE: there is none
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      OnState(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state);
    } else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
      over_ = true;
    } else if (other != nullptr) {
      other(event, user);
    }
  }
}

// The life of every session: begin when READY, end when STOPPING, leave when EXITING or lost.
void Session::OnState(XrSessionState state) {
  focused_ = state == XR_SESSION_STATE_FOCUSED;
  if (state == XR_SESSION_STATE_READY) {
    XrSessionBeginInfo begin{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    running_ = XR_SUCCEEDED(xrBeginSession(session_, &begin));
  } else if (state == XR_SESSION_STATE_STOPPING) {
    xrEndSession(session_);
    running_ = false;
  } else if (state == XR_SESSION_STATE_EXITING || state == XR_SESSION_STATE_LOSS_PENDING) {
    over_ = true;
  }
}

XrTime Session::NextFrame() {
  if (headless_ || !running_) return Headless();
  return EmptyFrame();
}

XrTime Session::Headless() {
  const timespec period{0, kFramePeriod_ns};
  nanosleep(&period, nullptr);
  if (!running_ || to_time_ == nullptr) return 0;
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  XrTime time = 0;
  return XR_SUCCEEDED(to_time_(instance_, &now, &time)) ? time : 0;
}

// A session with graphics goes on (and gets the focus) only while it submits frames; they may be empty.
XrTime Session::EmptyFrame() {
  XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, XR_FALSE};
  if (XR_FAILED(xrWaitFrame(session_, nullptr, &state)) || XR_FAILED(xrBeginFrame(session_, nullptr))) return 0;
  XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                     XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
  return XR_SUCCEEDED(xrEndFrame(session_, &end)) ? state.predictedDisplayTime : 0;
}

}  // namespace example
