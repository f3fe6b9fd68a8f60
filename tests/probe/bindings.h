#pragma once
// The actions of this application, and which input of which controller it would like for each.

#include <openxr/openxr.h>

#include <string>
#include <vector>

namespace probe {

struct Actions {
  XrActionSet set = XR_NULL_HANDLE;
  XrAction grip = XR_NULL_HANDLE;
  XrAction aim = XR_NULL_HANDLE;
  XrAction tip = XR_NULL_HANDLE;         // only a stylus has one
  XrAction select = XR_NULL_HANDLE;      // boolean
  XrAction force = XR_NULL_HANDLE;       // float: trigger, or how hard the tip presses
  XrAction thumbstick = XR_NULL_HANDLE;  // vector2
  XrAction haptic = XR_NULL_HANDLE;
};

struct Binding {
  XrAction Actions::*action;
  const char* path;  // below /user/hand/<hand>
};

struct ProfileBindings {
  const char* name;       // on our command line
  const char* path;       // interaction profile
  const char* extension;  // needed for it; nullptr: part of OpenXR itself
  std::vector<Binding> bindings;
};

// nullptr if unknown.
const ProfileBindings* FindProfile(const std::string& name);

// Creates the action set and its actions for one hand. On failure `failed_call` names the function.
XrResult CreateActions(XrInstance instance, XrPath hand, Actions* actions, const char** failed_call);

XrResult Suggest(XrInstance instance, const std::string& hand_path, const ProfileBindings& profile,
                 const Actions& actions);

}  // namespace probe
