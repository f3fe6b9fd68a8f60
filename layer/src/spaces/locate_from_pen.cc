// The views and a tracked hand, located in a space of the pen.
#include "layer/src/spaces/locator.h"

namespace omni::layer {
namespace {

// The views' bits are those of a location.
static_assert(XR_VIEW_STATE_ORIENTATION_VALID_BIT == XR_SPACE_LOCATION_ORIENTATION_VALID_BIT &&
              XR_VIEW_STATE_POSITION_VALID_BIT == XR_SPACE_LOCATION_POSITION_VALID_BIT &&
              XR_VIEW_STATE_ORIENTATION_TRACKED_BIT == XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT &&
              XR_VIEW_STATE_POSITION_TRACKED_BIT == XR_SPACE_LOCATION_POSITION_TRACKED_BIT);

// A joint or view X in the pen's space S, from X in L.
Located InPen(const Located& X_SL, const LocationFields& location, const VelocityFields& velocity) {
  return Compose(X_SL, Read(location, velocity));
}

// L in the pen's space `base`. Nothing is valid where the pen does not feed that space.
Located AnchorIn(const Side& base, const PenAt& pen) { return base.pen() ? Inverse(pen.Locate(base.X_TS)) : Located{}; }

void MoveViews(const Located& X_SL, XrViewState& state, XrView* views, std::uint32_t count) {
  const XrSpaceLocationFlags flags_below = state.viewStateFlags;
  XrPosef none{{0, 0, 0, 1}, {0, 0, 0}};
  XrSpaceLocationFlags flags = flags_below;
  state.viewStateFlags = InPen(X_SL, {&flags, &none}, {}).flags;
  for (std::uint32_t i = 0; i < count; ++i) {
    flags = flags_below;
    const LocationFields fields{&flags, &views[i].pose};
    WriteLocation(InPen(X_SL, fields, {}), fields, {});
  }
}

// XR_FB_hand_tracking_aim and _capsules put poses of the base space into the same answer.
void MoveHandExtras(const Located& X_SL, void* chain) {
  const Pose& X = X_SL.motion.X;
  const bool known = (X_SL.flags & kValid) == kValid;
  if (auto* aim = FindInChain<XrHandTrackingAimStateFB>(chain, XR_TYPE_HAND_TRACKING_AIM_STATE_FB)) {
    if (!known) aim->status &= ~XR_HAND_TRACKING_AIM_VALID_BIT_FB;
    if (aim->status & XR_HAND_TRACKING_AIM_VALID_BIT_FB) aim->aimPose = ToXr(Compose(X, FromXr(aim->aimPose)));
  }
  if (auto* hull = FindInChain<XrHandTrackingCapsulesStateFB>(chain, XR_TYPE_HAND_TRACKING_CAPSULES_STATE_FB)) {
    if (!known) return;
    for (XrHandCapsuleFB& capsule : hull->capsules)
      for (XrVector3f& point : capsule.points) point = ToXr(X.p + X.q * FromXr(point));
  }
}

}  // namespace

XrResult Locator::LocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity,
                              uint32_t* count, XrView* views) {
  link_.SignalAlive();
  const bool readable = info && info->type == XR_TYPE_VIEW_LOCATE_INFO && state && state->type == XR_TYPE_VIEW_STATE;
  const Side base = readable ? SideOf(records_.spaces, info->space) : Side{};
  if (!base.ours()) return runtime_.next.LocateViews(session, info, state, capacity, count, views);

  const PenAt pen = PenAtTime(link_, clock_, *base.session(), info->displayTime);
  XrViewLocateInfo changed = *info;
  changed.space = pen.Below(base);
  const XrResult result = runtime_.next.LocateViews(session, &changed, state, capacity, count, views);
  if (XR_FAILED(result)) return result;
  MoveViews(AnchorIn(base, pen), *state, views, capacity == 0 ? 0 : std::min(capacity, *count));
  return result;
}

XrResult Locator::CreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT* info,
                                       XrHandTrackerEXT* tracker) {
  const XrResult result = runtime_.next.CreateHandTrackerEXT(session, info, tracker);
  link_.SignalAlive();
  auto record = records_.sessions.Find(session);
  if (XR_SUCCEEDED(result) && record) hand_trackers_.Insert(*tracker, std::move(record));
  return result;
}

XrResult Locator::DestroyHandTrackerEXT(XrHandTrackerEXT tracker) {
  const XrResult result = runtime_.next.DestroyHandTrackerEXT(tracker);
  link_.SignalAlive();
  if (XR_SUCCEEDED(result)) hand_trackers_.Erase(tracker);
  return result;
}

XrResult Locator::LocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info,
                                      XrHandJointLocationsEXT* locations) {
  link_.SignalAlive();
  const bool readable = info && info->type == XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT && locations &&
                        locations->type == XR_TYPE_HAND_JOINT_LOCATIONS_EXT;
  const Side base = readable ? SideOf(records_.spaces, info->baseSpace) : Side{};
  if (!base.ours()) return runtime_.next.LocateHandJointsEXT(tracker, info, locations);

  const PenAt pen = PenAtTime(link_, clock_, *base.session(), info->time);
  XrHandJointsLocateInfoEXT changed = *info;
  changed.baseSpace = pen.Below(base);
  const XrResult result = runtime_.next.LocateHandJointsEXT(tracker, &changed, locations);
  if (XR_FAILED(result)) return result;
  const Located X_SL = AnchorIn(base, pen);
  auto* const velocities = FindInChain<XrHandJointVelocitiesEXT>(locations->next, XR_TYPE_HAND_JOINT_VELOCITIES_EXT);
  for (std::uint32_t i = 0; i < locations->jointCount; ++i) {
    XrHandJointLocationEXT& joint = locations->jointLocations[i];
    const LocationFields fields{&joint.locationFlags, &joint.pose};
    const VelocityFields velocity = FieldsOf(velocities ? &velocities->jointVelocities[i] : nullptr);
    WriteLocation(InPen(X_SL, fields, velocity), fields, velocity);
  }
  MoveHandExtras(X_SL, locations->next);
  return result;
}

}  // namespace omni::layer
