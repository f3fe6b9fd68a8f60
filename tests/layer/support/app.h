// An ordinary OpenXR application, reduced to what the layer's tests need.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "tests/layer/support/fake_service.h"
#include "tests/runtime/hooks.h"

namespace omni::test {

inline constexpr const char* kLayer = "XR_APILAYER_OMNI_stylus";
inline constexpr const char* kMxInk = "/interaction_profiles/logitech/mx_ink_stylus_logitech";
inline constexpr const char* kOmniStylus = "/interaction_profiles/omni/stylus_omnix1";
inline constexpr const char* kGeneric = "/interaction_profiles/khr/generic_controller";
inline constexpr const char* kIndex = "/interaction_profiles/valve/index_controller";
inline constexpr const char* kTouch = "/interaction_profiles/oculus/touch_controller";
inline constexpr const char* kSimple = "/interaction_profiles/khr/simple_controller";
// XrTime - CLOCK_MONOTONIC of the test runtime.
inline constexpr XrTime kRuntimeOffset_ns = 1'000'000'000'000;

struct AppOptions {
  bool layer = true;
  std::vector<const char*> profiles = {kTouch};
  bool mx_ink_extension = false;
  std::vector<const char*> extensions = {};  // further ones
  bool begin = true;                         // begins the session and polls until it is focused
  bool attach = true;                        // suggests and attaches
  const char* name = "layer test";
  bool timespec_extension = true;
};

struct Bound {
  XrAction action;
  const char* path;
};

class App {
 public:
  explicit App(const AppOptions& options = {});
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  XrPath Path(const std::string& text) const;
  std::string Text(XrPath path) const;
  XrResult Suggest(const char* profile, const std::vector<Bound>& bindings) const;
  XrResult SuggestUsual(const char* profile) const;
  XrResult Attach() const;
  XrResult Sync() const;
  XrResult SyncSets(const std::vector<XrActiveActionSet>& sets) const;

  // Polls until the queue is empty and appends to `events`.
  void Poll();
  void PollUntilFocused();
  // Keeps the pen alive and syncs until `done`, at most a few seconds. False: timed out.
  bool SyncUntil(FakeService& service, const std::function<bool()>& done);
  // ... until the right hand has this profile (nullptr: until it has none).
  bool WaitProfile(FakeService& service, const char* profile);

  std::string Profile(XrPath user_path) const;
  XrActionStateBoolean Bool(XrAction action, XrPath subaction) const;
  XrActionStateFloat Float(XrAction action, XrPath subaction) const;
  XrActionStateVector2f Vector(XrAction action, XrPath subaction) const;
  bool PoseActive(XrAction action, XrPath subaction) const;
  XrSpace ActionSpace(XrAction action, XrPath subaction, const XrPosef& offset = {{0, 0, 0, 1}, {0, 0, 0}}) const;
  XrSpace ReferenceSpace(XrReferenceSpaceType type, const XrPosef& offset = {{0, 0, 0, 1}, {0, 0, 0}}) const;
  XrResult Vibrate(XrPath subaction, float amplitude) const;

  int CountEvents(XrStructureType type) const;

  XrInstance instance = XR_NULL_HANDLE;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  XrSession session = XR_NULL_HANDLE;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  XrPath left = XR_NULL_PATH;
  XrPath right = XR_NULL_PATH;
  XrActionSet set = XR_NULL_HANDLE;
  // With both hands as subaction paths:
  XrAction pose = XR_NULL_HANDLE, select = XR_NULL_HANDLE, force = XR_NULL_HANDLE, stick = XR_NULL_HANDLE;
  XrAction squeeze = XR_NULL_HANDLE, haptic = XR_NULL_HANDLE, unbound = XR_NULL_HANDLE;
  XrAction plain = XR_NULL_HANDLE;  // boolean without subaction paths
  std::vector<XrStructureType> events;

  XrAction MakeAction(XrActionSet in, const char* name, XrActionType type, bool with_hands = true) const;
  XrActionSet MakeSet(const char* name, std::uint32_t priority) const;

 private:
  void MakeInstance(const AppOptions& options);
  void MakeActions();
};

// A function of an extension, as every application gets it; null: there is none.
template <class Function>
Function FunctionOf(XrInstance instance, const char* name) {
  PFN_xrVoidFunction function = nullptr;
  if (XR_FAILED(xrGetInstanceProcAddr(instance, name, &function))) return nullptr;
  return reinterpret_cast<Function>(function);
}

// Result text, for messages.
std::string Name(XrResult result);

void Pause_ms(long ms);
// How long a test waits for what another thread does: $OMNI_TEST_PATIENCE_S, else 20 s.
std::int64_t Patience_ns();
// Waits for it that long; false: timed out.
bool Eventually(const std::function<bool()>& done);

}  // namespace omni::test
