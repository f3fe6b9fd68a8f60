// What the examples need besides OpenXR: their command line; and to get a session without drawing anything,
// XR_MND_headless where the runtime offers it, else a Vulkan device, with which they submit frames without layers.
#pragma once

#include <openxr/openxr.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace example {

struct Options {
  std::string hand = "right";
  std::string name;  // what the runtime, and omnid's files in apps.d, see
  double seconds = 10;
};

// [--hand right|left] [--seconds S] [--name NAME]; `options.name` is at first the program's. Empty: continue. Otherwise
// the exit status: 0, --help was printed; 2, something else was given, and stderr says what.
std::optional<int> ParseArguments(int argc, char** argv, Options& options);

// Instance extensions of the runtime and of the layers that are loaded for every application.
std::vector<std::string> AvailableExtensions();
bool Contains(const std::vector<std::string>& names, const char* name);

// An instance of OpenXR 1.0 with these extensions; `name` is what the runtime, and omnid's files in apps.d, see.
// XR_NULL_HANDLE: `problem` says why.
XrInstance CreateInstance(const std::string& name, const std::vector<const char*>& extensions, std::string* problem);

// Destroyed with everything below it.
struct Instance {
  XrInstance handle = XR_NULL_HANDLE;
  ~Instance() {
    if (handle != XR_NULL_HANDLE) xrDestroyInstance(handle);
  }
};

class Session {
 public:
  // Before xrCreateInstance: the extensions to enable for a session. Empty: no session is possible; `problem` says why.
  static std::vector<const char*> Extensions(const std::vector<std::string>& offered, std::string* problem);

  // Creates the session with what Extensions() chose; on failure handle() is XR_NULL_HANDLE and problem() says why.
  Session(XrInstance instance, const std::vector<const char*>& extensions);
  ~Session();  // the instance must still be there
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  XrSession handle() const { return session_; }
  const std::string& problem() const { return problem_; }
  bool running() const { return running_; }  // between xrBeginSession and xrEndSession
  bool over() const { return over_; }        // the runtime has ended it
  bool focused() const { return focused_; }  // input and forces are ours

  // Once per pass: handles the runtime's events and begins or ends the session accordingly. All other events go to
  // `other` if it is not null.
  void PollEvents(void (*other)(const XrEventDataBuffer& event, void* user), void* user);

  // Waits for the next frame, and submits an empty one where there are graphics. The time for which poses are wanted:
  // now without graphics, else when the frame will be seen. 0: not running, or the runtime returned an error.
  XrTime NextFrame();

 private:
  struct Vulkan;  // vulkan.cc, or vulkan_absent.cc where it is built without

  void OnState(XrSessionState state);
  XrTime Headless();
  XrTime EmptyFrame();

  XrInstance instance_ = XR_NULL_HANDLE;
  XrSession session_ = XR_NULL_HANDLE;
  std::string problem_;
  bool running_ = false;
  bool over_ = false;
  bool focused_ = false;
  bool headless_ = false;
  XrResult(XRAPI_PTR* to_time_)(XrInstance, const struct timespec*, XrTime*) = nullptr;
  std::shared_ptr<Vulkan> vulkan_;

  // vulkan.cc
  static const char* VulkanExtension();  // null: built without
  // The graphics binding to chain to XrSessionCreateInfo; null: problem_ says why.
  const void* CreateVulkan(XrSystemId system);
};

}  // namespace example
