// Spaces. An action space of ours is a real space of the runtime plus a record: calls that we do not know treat it as
// unlocatable instead of failing.
#include <unistd.h>

#include "layer/src/spaces/locator.h"

namespace omni::layer {
namespace {

std::vector<XrReferenceSpaceType> SupportedSpaces(const Dispatch& next, XrSession session) {
  std::uint32_t count = 0;
  if (XR_FAILED(next.EnumerateReferenceSpaces(session, 0, &count, nullptr))) return {};
  std::vector<XrReferenceSpaceType> offered(count);
  if (XR_FAILED(next.EnumerateReferenceSpaces(session, count, &count, offered.data()))) return {};
  offered.resize(std::min<std::size_t>(count, offered.size()));
  return offered;
}

}  // namespace

// LOCAL is always tried: every runtime must have it, and the default base pose is given in it.
void Locator::MakeAnchors(Session& session) {
  const std::vector<XrReferenceSpaceType> offered = SupportedSpaces(runtime_.next, session.handle);
  for (std::size_t i = 0; i < kAnchorTypes.size(); ++i) {
    const XrReferenceSpaceType type = kAnchorTypes[i];
    const bool is_offered = std::find(offered.begin(), offered.end(), type) != offered.end();
    if (!is_offered && type != XR_REFERENCE_SPACE_TYPE_LOCAL) continue;
    const XrReferenceSpaceCreateInfo info{
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, {{0, 0, 0, 1}, {0, 0, 0}}};
    if (XR_FAILED(runtime_.next.CreateReferenceSpace(session.handle, &info, &session.anchors[i])))
      session.anchors[i] = XR_NULL_HANDLE;
  }
  if (session.AnchorSpace(XR_REFERENCE_SPACE_TYPE_LOCAL) == XR_NULL_HANDLE)
    log_.WriteLine("the runtime has no LOCAL space: until the base is aligned the pen has no pose in this session");
}

XrResult Locator::CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  const XrResult result = runtime_.next.CreateActionSpace(session, info, space);
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = record;
  made->action = records_.actions.Find(info->action);
  made->subaction = info->subactionPath;
  made->X_PS = FromXr(info->poseInActionSpace);
  if (!made->action) return result;
  records_.spaces.Insert(*space, made);
  const std::shared_lock lock(record->mutex);
  record->actions.UpdateServedBy(*made);
  return result;
}

XrResult Locator::CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  const XrResult result = runtime_.next.CreateReferenceSpace(session, info, space);
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  if (XR_FAILED(result) || !record) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = record;
  made->reference = info->referenceSpaceType;
  records_.spaces.Insert(*space, std::move(made));
  return result;
}

void Locator::EndOf(XrSession session) {
  records_.spaces.EraseIf([session](const Space& space) { return space.session && space.session->handle == session; });
  hand_trackers_.EraseIf([session](const Session& owner) { return owner.handle == session; });
}

// One call down, into the application's own structure: the runtime fills what else is chained to it. It also checks
// handles and time.
XrResult Locator::LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location) {
  link_.SignalAlive();
  const Side s = SideOf(records_.spaces, space);
  const Side b = SideOf(records_.spaces, base);
  const bool one_session = !s.ours() || !b.ours() || s.session() == b.session();
  if ((!s.ours() && !b.ours()) || !one_session || !location || location->type != XR_TYPE_SPACE_LOCATION)
    return runtime_.next.LocateSpace(space, base, time, location);

  const PenAt pen = PenAtTime(link_, clock_, *(s.ours() ? s : b).session(), time);
  const XrResult result = runtime_.next.LocateSpace(pen.Below(s), pen.Below(b), time, location);
  if (XR_FAILED(result)) return result;
  const LocationFields fields{&location->locationFlags, &location->pose};
  const VelocityFields velocity = FieldsOf(FindInChain<XrSpaceVelocity>(location->next, XR_TYPE_SPACE_VELOCITY));
  WriteLocation(Between(s, b, FromBelow(fields, velocity, s, b), pen), fields, velocity);
  return result;
}

XrResult Locator::LocateInBase(const Session& session, XrSpace space, XrTime time, Located& X_OS) {
  X_OS = {};
  const Side s = SideOf(records_.spaces, space);
  const PenAt pen = PenAtTime(link_, clock_, session, time);
  if (s.pen() && s.session() == &session) {
    X_OS = PenIn(Motion{}, pen.tool, s.X_TS);
    return XR_SUCCESS;
  }
  // Also without a known base pose: the runtime checks the space and the time.
  if (pen.anchor == XR_NULL_HANDLE) return XR_SUCCESS;
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY, nullptr, 0, {0, 0, 0}, {0, 0, 0}};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  const XrResult result = runtime_.next.LocateSpace(space, pen.anchor, time, &location);
  if (XR_FAILED(result) || s.served_by == kServedByNobody || !pen.base_pose.valid) return result;
  Side anchor;
  anchor.served_by = 0;  // stands for L, as a space of the pen does
  const Located X_LS = FromBelow({&location.locationFlags, &location.pose}, FieldsOf(&velocity), s, anchor);
  Located X_LO;
  X_LO.motion = pen.X_LO;
  X_LO.flags = pen.base_pose.tracked ? kValid | kTracked : kValid;
  X_LO.velocity_flags = kVelocityValid;
  X_OS = Compose(Inverse(X_LO), X_LS);
  return result;
}

}  // namespace omni::layer
