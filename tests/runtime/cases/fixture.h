#pragma once
// Drives the test runtime as an application would: through the system's OpenXR loader.

#include <gtest/gtest.h>
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <string>
#include <vector>

#include "tests/runtime/hooks.h"

namespace omni::runtime {

inline constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};
inline const std::string kSimplePath = "/interaction_profiles/khr/simple_controller";
inline const std::string kTouchPath = "/interaction_profiles/oculus/touch_controller";

// The start of a structure of this type, the rest zero.
template <class T>
T Make(XrStructureType type) {
  T structure{};
  structure.type = type;
  return structure;
}

// The result of locating a space.
struct Where {
  XrResult result;
  XrSpaceLocation location;
  XrSpaceVelocity velocity;
  bool valid() const;
  bool tracked() const;
};

class RuntimeTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  XrResult CreateInstance(const std::vector<const char*>& extensions, XrVersion api_version = XR_MAKE_VERSION(1, 0, 0));
  void DestroyInstance();
  XrResult CreateSession();
  // Instance with both extensions, session, set "main".
  void Start();
  // Polls (and begins) until the session is FOCUSED.
  void Focus();
  // Every event that is there, in order.
  std::vector<XrEventDataBuffer> Poll();
  // Polls until there is nothing more; the states the session went through.
  std::vector<XrSessionState> PollStates();

  XrPath Path(const std::string& text);
  std::string Text(XrPath path);
  XrActionSet AddSet(const std::string& name, uint32_t priority = 0);
  XrResult TryAction(XrActionSet set, const std::string& name, XrActionType type, const std::vector<XrPath>& subactions,
                     XrAction* action);
  XrAction AddAction(const std::string& name, XrActionType type, const std::vector<std::string>& hands = {});
  XrAction AddActionTo(XrActionSet set, const std::string& name, XrActionType type,
                       const std::vector<std::string>& hands = {});
  struct Binding {
    XrAction action;
    std::string path;
  };
  XrResult Suggest(const std::string& profile, const std::vector<Binding>& bindings);
  XrResult Attach(const std::vector<XrActionSet>& sets);
  // Attach "main" and go to FOCUSED.
  void AttachAndFocus();
  XrResult Sync(const std::vector<XrActiveActionSet>& active);
  XrResult Sync() { return Sync({{set_, XR_NULL_PATH}}); }

  XrActionStateBoolean Boolean(XrAction action, const std::string& subaction = "");
  XrActionStateFloat Float(XrAction action, const std::string& subaction = "");
  XrActionStateVector2f Vector2(XrAction action, const std::string& subaction = "");
  bool PoseActive(XrAction action, const std::string& subaction = "");
  XrResult Current(XrPath top_level, XrPath* profile);
  // "" for XR_NULL_PATH.
  std::string CurrentProfile(const std::string& top_level);

  XrSpace ActionSpace(XrAction action, const std::string& subaction = "", const XrPosef& offset = kHere);
  XrSpace ReferenceSpace(XrReferenceSpaceType type, const XrPosef& offset = kHere);
  XrTime Now();
  Where Locate(XrSpace space, XrSpace base, XrTime time = 0);

  XrInstance instance_ = XR_NULL_HANDLE;
  XrSession session_ = XR_NULL_HANDLE;
  XrActionSet set_ = XR_NULL_HANDLE;
};

}  // namespace omni::runtime
