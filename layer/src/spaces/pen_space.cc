#include "layer/src/spaces/pen_space.h"

#include "service/base/clock.h"

namespace omni::layer {
namespace {

// Does not move relative to the anchor. A side in a space of the pen stands for the anchor itself.
bool StandsStill(const Side& side) {
  if (side.pen()) return true;
  if (!side.space || side.space->action) return false;
  const int type = side.space->reference;
  return type == XR_REFERENCE_SPACE_TYPE_LOCAL || type == XR_REFERENCE_SPACE_TYPE_STAGE ||
         type == kReferenceSpaceTypeLocalFloor;
}

}  // namespace

Side SideOf(const Instance& instance, XrSpace handle) {
  Side side;
  side.handle = handle;
  side.space = instance.spaces.Find(handle);
  if (!side.space) return side;
  side.served_by = side.space->served_by.load(std::memory_order_acquire);
  if (side.pen() && side.space->focused_only && !side.space->session->focused) side.served_by = kServedByNobody;
  if (side.pen()) side.X_TS = Compose(side.space->session->actions.PosePart(side.served_by), side.space->X_PS);
  return side;
}

PenAt PenAtTime(const Instance& instance, const Session& session, XrTime time) {
  PenAt pen;
  pen.base_pose = session.base_pose.At(time);
  pen.anchor = session.Anchor(pen.base_pose.space);
  if (const auto reader = instance.link.reader())
    pen.tool = ToolMotionAt(*reader, instance.clock.ToMonotonic(time), base::MonotonicNow_ns());
  return pen;
}

Located PenAt::Locate(const Pose& X_TS) const noexcept {
  if (!anchor || !base_pose.valid) return {};
  Located out = PenIn(base_pose.X_LO, tool, X_TS);
  if (!base_pose.tracked) out.flags &= ~kTracked;
  return out;
}

Located Between(const Side& s, const Side& b, const Located& below, const PenAt& pen) noexcept {
  if (s.pen() && b.pen()) {  // one rigid body: known even when it is not seen
    Located rigid;
    rigid.motion.X = Compose(Inverse(b.X_TS), s.X_TS);
    rigid.flags = kValid | kTracked;
    rigid.velocity_flags = kVelocityValid;
    return rigid;
  }
  if (s.served_by == kServedByNobody || b.served_by == kServedByNobody) return {};
  if (s.pen()) return Chain(below, pen.Locate(s.X_TS));
  return Chain(Invert(pen.Locate(b.X_TS)), below);
}

Located FromBelow(const LocationFields& location, const VelocityFields& velocity, const Side& s,
                  const Side& b) noexcept {
  Located below = Read(location, velocity);
  if (below.flags != 0 && StandsStill(s) && StandsStill(b)) below.velocity_flags = kVelocityValid;
  return below;
}

}  // namespace omni::layer
