#include "align/hands.h"

#include <cstdio>

namespace align {
namespace {

constexpr const char* kHandPaths[] = {"/user/hand/left", "/user/hand/right"};

template <class Function>
void Load(XrInstance instance, const char* name, Function& function) {
  PFN_xrVoidFunction found = nullptr;
  if (XR_SUCCEEDED(xrGetInstanceProcAddr(instance, name, &found))) function = reinterpret_cast<Function>(found);
}

}  // namespace

bool Failed(XrResult result, const char* call, std::string* problem) {
  if (XR_SUCCEEDED(result)) return false;
  *problem = std::string(call) + ": XrResult " + std::to_string(result);
  return true;
}

Hands::Hands(XrInstance instance, XrSession session, XrReferenceSpaceType space, bool fingers, std::string* problem)
    : instance_(instance), session_(session) {
  XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, space, kHere};
  if (Failed(xrCreateReferenceSpace(session, &info, &base_), "xrCreateReferenceSpace", problem)) return;
  if (!MakeActions(problem)) return;
  if (fingers && !MakeFingers()) *problem = "the runtime offers XR_EXT_hand_tracking, but not for this headset";
}

Hands::~Hands() {
  for (const XrHandTrackerEXT tracker : trackers_) {
    if (tracker != XR_NULL_HANDLE) destroy_tracker_(tracker);
  }
}

bool Hands::MakeActions(std::string* problem) {
  for (int hand = 0; hand < 2; ++hand) {
    if (Failed(xrStringToPath(instance_, kHandPaths[hand], &hands_[hand]), "xrStringToPath", problem)) return false;
  }
  XrActionSetCreateInfo set{XR_TYPE_ACTION_SET_CREATE_INFO, nullptr, "align", "Align the base", 0};
  if (Failed(xrCreateActionSet(instance_, &set, &set_), "xrCreateActionSet", problem)) return false;
  XrActionCreateInfo action{
      XR_TYPE_ACTION_CREATE_INFO, nullptr, "grip", XR_ACTION_TYPE_POSE_INPUT, 2, hands_.data(), "Grip"};
  if (Failed(xrCreateAction(set_, &action, &grip_), "xrCreateAction", problem)) return false;
  SuggestAll();
  XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set_};
  if (Failed(xrAttachSessionActionSets(session_, &attach), "xrAttachSessionActionSets", problem)) return false;
  for (int hand = 0; hand < 2; ++hand) {
    XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, grip_, hands_[hand], kHere};
    if (Failed(xrCreateActionSpace(session_, &info, &spaces_[hand]), "xrCreateActionSpace", problem)) return false;
  }
  return true;
}

void Hands::SuggestAll() const {
  for (const char* name : kProfiles) {
    XrPath profile = XR_NULL_PATH;
    std::array<XrActionSuggestedBinding, 2> bindings{};
    xrStringToPath(instance_, name, &profile);
    for (int hand = 0; hand < 2; ++hand) {
      bindings[hand].action = grip_;
      xrStringToPath(instance_, (std::string(kHandPaths[hand]) + "/input/grip/pose").c_str(), &bindings[hand].binding);
    }
    XrInteractionProfileSuggestedBinding suggested{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, profile, 2,
                                                   bindings.data()};
    xrSuggestInteractionProfileBindings(instance_, &suggested);
  }
}

bool Hands::MakeFingers() {
  Load(instance_, "xrCreateHandTrackerEXT", create_tracker_);
  Load(instance_, "xrDestroyHandTrackerEXT", destroy_tracker_);
  Load(instance_, "xrLocateHandJointsEXT", locate_joints_);
  if (create_tracker_ == nullptr || destroy_tracker_ == nullptr || locate_joints_ == nullptr) return false;
  for (int hand = 0; hand < 2; ++hand) {
    XrHandTrackerCreateInfoEXT info{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, nullptr,
                                    hand == 0 ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT, XR_HAND_JOINT_SET_DEFAULT_EXT};
    if (XR_FAILED(create_tracker_(session_, &info, &trackers_[hand]))) {
      trackers_[hand] = XR_NULL_HANDLE;
      return false;
    }
  }
  return true;
}

void Hands::AddFinger(int hand, XrTime time, std::vector<Seen>& seen) const {
  if (trackers_[hand] == XR_NULL_HANDLE) return;
  std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> joints{};
  XrHandJointLocationsEXT locations{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, nullptr, XR_FALSE,
                                    static_cast<uint32_t>(joints.size()), joints.data()};
  XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, base_, time};
  if (XR_FAILED(locate_joints_(trackers_[hand], &info, &locations)) || locations.isActive == XR_FALSE) return;
  const XrHandJointLocationEXT& tip = joints[XR_HAND_JOINT_INDEX_TIP_EXT];
  if ((tip.locationFlags & kTracked) != kTracked) return;
  seen.push_back({hand == 0 ? Part::kLeftFinger : Part::kRightFinger, tip.pose});
}

std::vector<Seen> Hands::Poll(XrTime time) {
  std::vector<Seen> seen;
  XrActiveActionSet active{set_, XR_NULL_PATH};
  XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
  if (time <= 0 || xrSyncActions(session_, &sync) != XR_SUCCESS) return seen;  // not focused: no input for us
  for (int hand = 0; hand < 2; ++hand) {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, kHere};
    if (XR_FAILED(xrLocateSpace(spaces_[hand], base_, time, &location))) continue;
    if ((location.locationFlags & kTracked) == kTracked) {
      seen.push_back({hand == 0 ? Part::kLeft : Part::kRight, location.pose});
    }
    AddFinger(hand, time, seen);
  }
  return seen;
}

}  // namespace align
