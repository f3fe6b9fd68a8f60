#include "align/hands.h"

namespace align {
namespace {

constexpr const char* kTrackerProfile = "/interaction_profiles/htc/vive_tracker_htcx";

}  // namespace

Follower::Follower(XrInstance instance, XrSession session, XrReferenceSpaceType space, const std::string& path,
                   std::string* problem)
    : session_(session) {
  XrPath followed = XR_NULL_PATH;
  const XrReferenceSpaceCreateInfo base{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, space, kHere};
  const XrActionSetCreateInfo set{XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, "follow", "Follow the base", 0};
  if (Failed(xrStringToPath(instance, path.c_str(), &followed), "xrStringToPath", problem) ||
      Failed(xrCreateReferenceSpace(session, &base, &base_), "xrCreateReferenceSpace", problem) ||
      Failed(xrCreateActionSet(instance, &set, &set_), "xrCreateActionSet", problem)) {
    return;
  }
  const XrActionCreateInfo action{
      XR_TYPE_ACTION_CREATE_INFO, nullptr, "grip", XR_ACTION_TYPE_POSE_INPUT, 1, &followed, "Grip"};
  bool known = false;
  if (XR_SUCCEEDED(xrCreateAction(set_, &action, &grip_))) {
    if (IsTracker(path)) known = Suggest(instance, kTrackerProfile, path);
    for (const char* profile : kProfiles) known = (!IsTracker(path) && Suggest(instance, profile, path)) || known;
  }
  if (!known) {
    *problem = path + ": the runtime has no such path; use /user/hand/left, /user/hand/right or the role of a tracker";
    return;
  }
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set_};
  const XrActionSpaceCreateInfo grip{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, grip_, followed, kHere};
  if (Failed(xrAttachSessionActionSets(session, &attach), "xrAttachSessionActionSets", problem)) return;
  Failed(xrCreateActionSpace(session, &grip, &space_), "xrCreateActionSpace", problem);
}

bool Follower::Suggest(XrInstance instance, const char* profile, const std::string& path) const {
  XrActionSuggestedBinding binding{grip_, XR_NULL_PATH};
  XrInteractionProfileSuggestedBinding suggested{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, XR_NULL_PATH,
                                                 1, &binding};
  return XR_SUCCEEDED(xrStringToPath(instance, profile, &suggested.interactionProfile)) &&
         XR_SUCCEEDED(xrStringToPath(instance, (path + "/input/grip/pose").c_str(), &binding.binding)) &&
         XR_SUCCEEDED(xrSuggestInteractionProfileBindings(instance, &suggested));
}

bool Follower::Poll(XrTime time, FollowedMotion* motion) {
  const XrActiveActionSet active{set_, XR_NULL_PATH};
  const XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
  if (time <= 0 || xrSyncActions(session_, &sync) != XR_SUCCESS) return false;  // not focused: no input for us
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY, nullptr, 0, {0, 0, 0}, {0, 0, 0}};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity, 0, kHere};
  if (XR_FAILED(xrLocateSpace(space_, base_, time, &location)) || (location.locationFlags & kTracked) != kTracked) {
    return false;
  }
  constexpr XrSpaceVelocityFlags kBoth = XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;
  *motion = {location.pose, (velocity.velocityFlags & kBoth) == kBoth, velocity.linearVelocity,
             velocity.angularVelocity};
  return true;
}

}  // namespace align
