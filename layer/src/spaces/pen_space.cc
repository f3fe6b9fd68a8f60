#include "layer/src/spaces/locator.h"

#include "layer/src/spaces/base_pose.h"
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

// Where no pose of it is known yet, it stays where it was measured, or is guessed to be.
void FollowBase(const BaseMotion& base, const Session& session, PenAt& pen) {
  if (!base.valid) return;
  pen.anchor = session.AnchorSpace(base.space);
  pen.X_LO = base.X_LO;
  pen.base_pose.valid = true;
  pen.base_pose.tracked = base.tracked;
}

}  // namespace

Side SideOf(const HandleMap<XrSpace, Space>& spaces, XrSpace handle) {
  Side side;
  side.handle = handle;
  side.space = spaces.Find(handle);
  if (!side.space) return side;
  side.served_by = side.space->served_by.load(std::memory_order_acquire);
  if (side.pen() && side.space->focused_only && !side.space->session->focused) side.served_by = kServedByNobody;
  if (side.pen()) side.X_TS = Compose(side.space->session->actions.PosePart(side.served_by), side.space->X_PS);
  return side;
}

PenAt PenAtTime(const ServiceLink& link, const RuntimeClock& clock, const Session& session, XrTime time) {
  PenAt pen;
  pen.base_pose = session.base_pose.At(time);
  pen.anchor = session.AnchorSpace(pen.base_pose.space);
  pen.X_LO.X = pen.base_pose.X_LO;
  const auto reader = link.reader();
  if (pen.base_pose.follows) pen.base_pose.tracked = false;
  if (!reader) return pen;
  const std::int64_t t_ns = clock.ToMonotonic(time);
  const std::int64_t now_ns = base::MonotonicNow_ns();
  pen.tool = ToolMotionAt(*reader, t_ns, now_ns);
  if (pen.base_pose.follows) FollowBase(BaseMotionAt(*reader, t_ns, now_ns), session, pen);
  return pen;
}

Located PenAt::Locate(const Pose& X_TS) const noexcept {
  if (!anchor || !base_pose.valid) return {};
  Located out = PenIn(X_LO, tool, X_TS);
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
  if (s.pen()) return Compose(below, pen.Locate(s.X_TS));
  return Compose(Inverse(pen.Locate(b.X_TS)), below);
}

Located FromBelow(const LocationFields& location, const VelocityFields& velocity, const Side& s,
                  const Side& b) noexcept {
  Located below = Read(location, velocity);
  if (below.flags != 0 && StandsStill(s) && StandsStill(b)) below.velocity_flags = kVelocityValid;
  return below;
}

}  // namespace omni::layer
