// Spaces. An action space of ours is a real space of the runtime plus a record: calls that we do not know treat it as
// unlocatable instead of failing.
#include "layer/src/fault.h"
#include "layer/src/instance.h"
#include "layer/src/locate.h"

namespace omni::layer {
namespace {

// X_LO while nobody has aligned the base.
const Pose kPlacement_LO = DefaultPlacement();

// A space's place in this call: whose it is and how far it is from the tool frame.
struct Side {
  std::shared_ptr<Space> space;  // null: not made through us
  int served_by = kServedByRuntime;
  Pose X_TS;
  bool pen() const { return served_by >= 0; }
};

Side SideOf(const Instance& instance, XrSpace handle) {
  Side side;
  side.space = instance.spaces.Find(handle);
  if (!side.space) return side;
  side.served_by = side.space->served_by.load(std::memory_order_acquire);
  if (side.pen()) side.X_TS = Compose(side.space->session->actions.PosePart(side.served_by), side.space->X_PS);
  if (side.pen() && OMNI_FAULT("offset-ignored")) side.X_TS = {};
  return side;
}

// Spaces that do not move against the anchor, so that an absent velocity means zero.
bool Static(const Side& side) {
  if (!side.space || side.space->action) return false;
  const int type = side.space->reference;
  return type == XR_REFERENCE_SPACE_TYPE_LOCAL || type == XR_REFERENCE_SPACE_TYPE_STAGE ||
         type == kReferenceSpaceTypeLocalFloor;
}

// `space` in `base` as the runtime knows it, with velocity; also finds the spec's errors in base and time.
XrResult LocateBelow(const Instance& instance, XrSpace space, XrSpace base, XrTime time, bool is_static, Located& out) {
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY, nullptr, 0, {0, 0, 0}, {0, 0, 0}};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  const XrResult result = instance.next.LocateSpace(space, base, time, &location);
  if (XR_FAILED(result)) return result;
  out.flags = location.locationFlags;
  out.velocity_flags = is_static && out.flags ? kVelocityValid : velocity.velocityFlags;
  out.motion.X = FromXr(location.pose);
  if (OMNI_FAULT("base-velocity-ignored")) velocity.velocityFlags = 0;
  if (velocity.velocityFlags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT) out.motion.v = FromXr(velocity.linearVelocity);
  if (velocity.velocityFlags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT) out.motion.w = FromXr(velocity.angularVelocity);
  return result;
}

}  // namespace

XrResult Instance::CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  const XrResult result = next.CreateActionSpace(session, info, space);
  link.Beat();
  const auto record = sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = record;
  made->action = actions.Find(info->action);
  made->subaction = info->subactionPath;
  made->X_PS = FromXr(info->poseInActionSpace);
  if (!made->action) return result;
  spaces.Insert(*space, made);
  const std::shared_lock lock(record->mutex);
  record->actions.Serve(*made);
  return result;
}

XrResult Instance::CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  const XrResult result = next.CreateReferenceSpace(session, info, space);
  link.Beat();
  const auto record = sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = record;
  made->reference = info->referenceSpaceType;
  spaces.Insert(*space, std::move(made));
  return result;
}

XrResult Instance::DestroySpace(XrSpace space) {
  const XrResult result = next.DestroySpace(space);
  link.Beat();
  if (XR_SUCCEEDED(result)) spaces.Erase(space);
  return result;
}

void Instance::UpdateSpaces(const Session& session) {
  spaces.ForEach([&](Space& space) {
    if (space.action && space.session.get() == &session) session.actions.Serve(space);
  });
}

XrResult Instance::LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  if (!OMNI_FAULT("no-sign-of-life")) link.Beat();
  const Side s = SideOf(*this, space);
  const Side b = SideOf(*this, base);
  const bool by_runtime = s.served_by == kServedByRuntime && b.served_by == kServedByRuntime;
  if (by_runtime || !location || location->type != XR_TYPE_SPACE_LOCATION)
    return next.LocateSpace(space, base, time, location);

  const Side& one = s.pen() ? s : b;  // of the pen, unless nobody serves the other and this is anything
  const XrSpace anchor = one.pen() ? one.space->session->anchor : XR_NULL_HANDLE;
  if (s.served_by == kServedByNobody || b.served_by == kServedByNobody || anchor == XR_NULL_HANDLE) {
    const XrResult result = next.LocateSpace(space, base, time, location);
    if (XR_SUCCEEDED(result)) Write(Located{}, *location);
    return result;
  }
  // The runtime's half. It also checks the runtime's handle and the time.
  Located below;
  const XrSpace target = s.pen() ? anchor : space;
  const XrSpace reference = b.pen() ? anchor : base;
  const XrResult result = LocateBelow(*this, target, reference, time, Static(s.pen() ? b : s), below);
  if (XR_FAILED(result)) return result;
  if (s.pen() && b.pen() && !OMNI_FAULT("rigid-pair-forgotten")) {  // one rigid body: known even when it is not seen
    Located rigid;
    rigid.motion.X = Compose(Inverse(b.X_TS), s.X_TS);
    rigid.flags = kValid | kTracked;
    rigid.velocity_flags = kVelocityValid;
    Write(rigid, *location);
    return result;
  }
  if (OMNI_FAULT("locate-ignores-time")) time = clock.ToXr(MonotonicNow_ns());
  ToolMotion tool;
  if (const auto reader = link.reader()) tool = ToolMotionAt(*reader, clock.ToMonotonic(time), MonotonicNow_ns());
  const Located pen = PenIn(kPlacement_LO, tool, s.pen() ? s.X_TS : b.X_TS);
  const bool inverts = !s.pen() && !OMNI_FAULT("base-not-inverted");
  Write(inverts ? Chain(Invert(pen), below) : Chain(below, pen), *location);
  return result;
}

}  // namespace omni::layer
