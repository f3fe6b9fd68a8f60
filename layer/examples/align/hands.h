// Where the runtime's controllers and fingertips are, or one controller or tracker with its velocity, in one reference
// space.
#pragma once

#include <openxr/openxr.h>

#include <array>
#include <string>
#include <vector>

namespace align {

// All controllers have a grip pose; a runtime rejects a profile that it does not know, which does no harm.
inline constexpr std::array kProfiles{
    "/interaction_profiles/khr/simple_controller",       "/interaction_profiles/oculus/touch_controller",
    "/interaction_profiles/valve/index_controller",      "/interaction_profiles/htc/vive_controller",
    "/interaction_profiles/microsoft/motion_controller",
};
inline constexpr XrSpaceLocationFlags kTracked =
    XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT |
    XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
inline constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};

// `problem`: which call failed, and how.
bool Failed(XrResult result, const char* call, std::string* problem);

enum class Part { kLeft, kRight, kLeftFinger, kRightFinger };
inline constexpr std::array kPartNames{"left", "right", "left_finger", "right_finger"};

struct Seen {
  Part part;
  XrPosef pose;
};

class Hands {
 public:
  // Actions, bindings and spaces; with `fingers` hand trackers as well. `problem` empty: it worked.
  Hands(XrInstance instance, XrSession session, XrReferenceSpaceType space, bool fingers, std::string* problem);
  ~Hands();
  Hands(const Hands&) = delete;
  Hands& operator=(const Hands&) = delete;

  // Only what the runtime tracks now; guessed poses are left out.
  std::vector<Seen> Poll(XrTime time);

 private:
  bool MakeActions(std::string* problem);
  void SuggestAll() const;
  bool MakeFingers();
  void AddFinger(int hand, XrTime time, std::vector<Seen>& seen) const;

  XrInstance instance_;
  XrSession session_;
  XrSpace base_ = XR_NULL_HANDLE;
  XrActionSet set_ = XR_NULL_HANDLE;
  XrAction grip_ = XR_NULL_HANDLE;
  std::array<XrPath, 2> hands_{};
  std::array<XrSpace, 2> spaces_{};
  std::array<XrHandTrackerEXT, 2> trackers_{};
  PFN_xrCreateHandTrackerEXT create_tracker_ = nullptr;
  PFN_xrDestroyHandTrackerEXT destroy_tracker_ = nullptr;
  PFN_xrLocateHandJointsEXT locate_joints_ = nullptr;
};

inline constexpr const char* kTrackerExtension = "XR_HTCX_vive_tracker_interaction";

struct FollowedMotion {
  XrPosef pose{{0, 0, 0, 1}, {0, 0, 0}};
  bool moves = false;  // the runtime knows the velocities
  XrVector3f velocity{0, 0, 0}, turn_rate{0, 0, 0};
};

class Follower {
 public:
  static bool IsTracker(const std::string& path) { return path.rfind("/user/vive_tracker_htcx/", 0) == 0; }

  // Its grip pose. `path`: /user/hand/left, /user/hand/right, or the role of a tracker. `problem` empty: it worked.
  Follower(XrInstance instance, XrSession session, XrReferenceSpaceType space, const std::string& path,
           std::string* problem);

  // False: the runtime does not track it now.
  bool Poll(XrTime time, FollowedMotion* motion);

 private:
  bool Suggest(XrInstance instance, const char* profile, const std::string& path) const;

  XrSession session_;
  XrSpace base_ = XR_NULL_HANDLE, space_ = XR_NULL_HANDLE;
  XrActionSet set_ = XR_NULL_HANDLE;
  XrAction grip_ = XR_NULL_HANDLE;
};

}  // namespace align
