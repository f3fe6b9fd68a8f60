// What the program does each frame, and what it asks besides.
#include <cstring>
#include <utility>

#include "tests/layer/patterns/player.h"
#include "tests/layer/support/app.h"

namespace omni::test::patterns {
namespace {

template <class Event>
Event As(const XrEventDataBuffer& buffer) {
  Event event;
  std::memcpy(&event, &buffer, sizeof(event));
  return event;
}

}  // namespace

void Player::BeginWhenReady(XrSessionState state) {
  state_ = state;
  if (state == XR_SESSION_STATE_READY) {
    const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    Must(xrBeginSession(session_, &info), "xrBeginSession");
    running_ = true;
  }
  if (state == XR_SESSION_STATE_STOPPING) {
    Must(xrEndSession(session_), "xrEndSession");
    running_ = false;
  }
}

void Player::Poll() {
  for (XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER}; xrPollEvent(instance_, &event) == XR_SUCCESS;
       event = {XR_TYPE_EVENT_DATA_BUFFER}) {
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      const auto changed = As<XrEventDataSessionStateChanged>(event);
      if (changed.session == session_) BeginWhenReady(changed.state);
    }
    if (event.type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) {
      const bool ours = As<XrEventDataInteractionProfileChanged>(event).session == session_;
      if (ours && pattern_.profile_read == ProfileRead::kAtEvent) ReadProfiles();
      profile_event_ = profile_event_ || ours;
    }
    if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING && pattern_.new_base_at_recentre) {
      Must(xrDestroySpace(base_), "xrDestroySpace");
      MakeBase();
    }
  }
}

std::string Player::CurrentProfile(int hand) const {
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE};
  Must(xrGetCurrentInteractionProfile(session_, hand_paths_[static_cast<std::size_t>(hand)], &state),
       "xrGetCurrentInteractionProfile");
  return Text(state.interactionProfile);
}

// A profile that it never suggested means nothing to a program, or ends it.
void Player::ReadProfiles() {
  for (const int hand : pattern_.hands) {
    std::string& profile = profile_[static_cast<std::size_t>(hand)];
    profile = CurrentProfile(hand);
    if (!profile.empty() && !pattern_.FindProfile(profile)) ended_ = profile + " was never suggested";
  }
}

void Player::Frame() {
  Poll();
  if (!running_) return;
  std::vector<XrActiveActionSet> active;
  for (const auto& [key, set] : sets_) active.push_back({set, XR_NULL_PATH});
  const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, static_cast<std::uint32_t>(active.size()),
                               active.data()};
  Must(xrSyncActions(session_, &info), "xrSyncActions");
  const bool after_event =
      std::exchange(profile_event_, false) && pattern_.profile_read == ProfileRead::kAtSyncAfterEvent;
  if (after_event || pattern_.profile_read == ProfileRead::kEachFrame) ReadProfiles();
  for (const int index : Devices()) Read(DeviceOf(index), index);
}

void Player::Read(const PatternDevice& device, int index) {
  Seen& seen = seen_[static_cast<std::size_t>(index)];
  seen = {};
  if (pattern_.needs_profile && index != kPenDevice && profile(index).empty()) return;
  bool press_active = false;
  seen.pressed = IsPressed(device, index, press_active);
  if (pattern_.needs_press_active && !press_active) return;
  seen.there = IsThere(device, index, seen);
}

bool Player::IsThere(const PatternDevice& device, int index, Seen& seen) {
  const XrSpace space = SpaceOf(device, index);
  if (space == XR_NULL_HANDLE) return false;
  if (pattern_.needs_pose_active) {
    const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, ActionOf(device.pose, index),
                                    PathOf(device, index)};
    XrActionStatePose pose{XR_TYPE_ACTION_STATE_POSE};
    Must(xrGetActionStatePose(session_, &info, &pose), "xrGetActionStatePose");
    if (!pose.isActive) return false;
  }
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, pattern_.with_velocity ? &velocity : nullptr};
  Must(xrLocateSpace(space, base_, Now_ns() + kRuntimeOffset_ns, &location), "xrLocateSpace");
  constexpr XrSpaceLocationFlags kTracked =
      XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
  seen.position = location.pose.position;
  seen.tracked = (location.locationFlags & kTracked) == kTracked;
  const bool all = (location.locationFlags & pattern_.all_flags) == pattern_.all_flags;
  return all && (pattern_.any_flag == 0 || (location.locationFlags & pattern_.any_flag) != 0);
}

bool Player::IsPressed(const PatternDevice& device, int index, bool& active) const {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, ActionOf(device.press, index),
                                  PathOf(device, index)};
  if (info.action == XR_NULL_HANDLE) return false;
  bool pressed = false;
  if (pattern_.Find(device.press)->type == XR_ACTION_TYPE_FLOAT_INPUT) {
    XrActionStateFloat state{XR_TYPE_ACTION_STATE_FLOAT};
    Must(xrGetActionStateFloat(session_, &info, &state), "xrGetActionStateFloat");
    active = state.isActive == XR_TRUE;
    pressed = state.currentState > device.threshold;
  } else {
    XrActionStateBoolean state{XR_TYPE_ACTION_STATE_BOOLEAN};
    Must(xrGetActionStateBoolean(session_, &info, &state), "xrGetActionStateBoolean");
    active = state.isActive == XR_TRUE;
    pressed = state.currentState == XR_TRUE;
  }
  return pressed && (active || !device.press_checks_active);
}

XrResult Player::Vibrate(int index) const {
  const PatternDevice& device = DeviceOf(index);
  const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, ActionOf(device.haptic, index),
                                PathOf(device, index)};
  if (info.action == XR_NULL_HANDLE) return XR_SUCCESS;  // it has none in this hand now
  const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, 20'000'000, 150.0f, 0.3f};
  return xrApplyHapticFeedback(session_, &info,
                               static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration)));
}

std::vector<std::string> Player::Names(int hand) const {
  const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr,
                                                  ActionOf(DeviceOf(hand).pose, hand)};
  if (info.action == XR_NULL_HANDLE) return {};
  std::uint32_t count = 0;
  Must(xrEnumerateBoundSourcesForAction(session_, &info, 0, &count, nullptr), "xrEnumerateBoundSourcesForAction");
  std::vector<XrPath> sources(count);
  Must(xrEnumerateBoundSourcesForAction(session_, &info, count, &count, sources.data()), "... of that size");
  std::vector<std::string> names;
  for (const XrPath source : sources) {
    if (Text(source).rfind("/user/hand/" + std::string(kSides[hand]) + "/", 0) != 0) continue;
    const XrInputSourceLocalizedNameGetInfo get{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr, source,
                                                XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT |
                                                    XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT |
                                                    XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT};
    std::uint32_t length = 0;
    Must(xrGetInputSourceLocalizedName(session_, &get, 0, &length, nullptr), "xrGetInputSourceLocalizedName");
    std::string text(length, '\0');
    Must(xrGetInputSourceLocalizedName(session_, &get, length, &length, text.data()), "... of that length");
    names.push_back(text.c_str());
  }
  return names;
}

std::vector<std::uint64_t> Player::Models(int hand) const {
  const XrPath path = hand_paths_[static_cast<std::size_t>(hand)];
  if (pattern_.model_by == ModelBy::kMsft) {
    XrControllerModelKeyStateMSFT key{XR_TYPE_CONTROLLER_MODEL_KEY_STATE_MSFT};
    const auto get = FunctionOf<PFN_xrGetControllerModelKeyMSFT>(instance_, "xrGetControllerModelKeyMSFT");
    Must(get(session_, path, &key), "xrGetControllerModelKeyMSFT");
    if (key.modelKey == XR_NULL_CONTROLLER_MODEL_KEY_MSFT) return {};
    return {key.modelKey};
  }
  if (pattern_.model_by != ModelBy::kInteraction) return {};
  const auto list =
      FunctionOf<PFN_xrEnumerateInteractionRenderModelIdsEXT>(instance_, "xrEnumerateInteractionRenderModelIdsEXT");
  const auto create = FunctionOf<PFN_xrCreateRenderModelEXT>(instance_, "xrCreateRenderModelEXT");
  const auto destroy = FunctionOf<PFN_xrDestroyRenderModelEXT>(instance_, "xrDestroyRenderModelEXT");
  const auto place =
      FunctionOf<PFN_xrGetRenderModelPoseTopLevelUserPathEXT>(instance_, "xrGetRenderModelPoseTopLevelUserPathEXT");
  std::uint32_t count = 0;
  Must(list(session_, nullptr, 0, &count, nullptr), "xrEnumerateInteractionRenderModelIdsEXT");
  std::vector<XrRenderModelIdEXT> ids(count);
  Must(list(session_, nullptr, count, &count, ids.data()), "... of that size");
  std::vector<std::uint64_t> models;
  for (const XrRenderModelIdEXT id : ids) {
    const XrRenderModelCreateInfoEXT info{XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT, nullptr, id, 0, nullptr};
    XrRenderModelEXT model = XR_NULL_HANDLE;
    Must(create(session_, &info, &model), "xrCreateRenderModelEXT");
    const XrInteractionRenderModelTopLevelUserPathGetInfoEXT get{
        XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT, nullptr, 1, &path};
    XrPath at = XR_NULL_PATH;
    Must(place(model, &get, &at), "xrGetRenderModelPoseTopLevelUserPathEXT");
    Must(destroy(model), "xrDestroyRenderModelEXT");
    if (at == path) models.push_back(static_cast<std::uint64_t>(id));
  }
  return models;
}

}  // namespace omni::test::patterns
