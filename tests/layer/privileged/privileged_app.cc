// An OpenXR application that its user starts with more rights than the user has: loads the layer, makes an instance.
// Prints "secure" or "not secure" (AT_SECURE). Exit status 1: no instance.
#include <sys/auxv.h>

#include <cstdio>
#include <exception>

#include "tests/layer/mini_loader/mini_loader.h"

// Such a process cannot be traced, which the leak check needs.
extern "C" const char* __asan_default_options();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

int main() {
  using namespace omni::test;
  try {
    const MiniLoader loader({OmniLayer()});
    XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
    std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "privileged");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
    XrInstance instance = XR_NULL_HANDLE;
    if (loader.CreateInstance(info, &instance) != XR_SUCCESS) return 1;
    loader.Load(instance).DestroyInstance(instance);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "%s\n", problem.what());
    return 1;
  }
  std::puts(getauxval(AT_SECURE) != 0 ? "secure" : "not secure");
  return 0;
}
