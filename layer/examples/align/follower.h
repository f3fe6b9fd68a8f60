// Where one controller or tracker is, with its velocity, in one reference space.
#pragma once

#include <openxr/openxr.h>

#include <string>

namespace align {

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
