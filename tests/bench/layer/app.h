// The OpenXR application that times its own calls: headless, one pose action of each hand.
#pragma once

#include <time.h>

#define XR_USE_TIMESPEC
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

namespace omni::bench {

// Ends the program with a line on stderr where a call fails.
void Check(XrResult result, const char* what);

struct App {
  XrInstance instance = XR_NULL_HANDLE;
  XrSession session = XR_NULL_HANDLE;
  XrSpace local = XR_NULL_HANDLE;
  XrSpace right = XR_NULL_HANDLE;
  XrSpace left = XR_NULL_HANDLE;
  XrActionSet set = XR_NULL_HANDLE;
  XrAction pose = XR_NULL_HANDLE;
  XrPath left_path = XR_NULL_PATH, right_path = XR_NULL_PATH;
  PFN_xrConvertTimespecTimeToTimeKHR to_time = nullptr;
  PFN_xrVoidFunction locate_spaces = nullptr;  // xrLocateSpacesKHR; null: not available
};

// With whatever layers the environment enables.
void CreateInstance(App& app);
// Begun and focused.
void CreateSession(App& app);
// Suggested for the Touch controller, attached, with spaces.
void CreateActions(App& app);

XrTime Now(const App& app);
// Polls all events and syncs.
void Sync(const App& app);
// Syncs until the right hand's pose is valid; ends the program after 10 s.
void WaitForPen(const App& app);

}  // namespace omni::bench
