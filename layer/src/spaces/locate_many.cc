// xrLocateSpaces of OpenXR 1.1 and of XR_KHR_locate_spaces: as xrLocateSpace, for many spaces in one call down.
#include "layer/src/spaces/locator.h"

namespace omni::layer {
namespace {

bool NamesSpaces(const XrSpacesLocateInfo* info, const XrSpaceLocations* locations) {
  return info && info->type == XR_TYPE_SPACES_LOCATE_INFO && info->spaces && info->spaceCount > 0 && locations &&
         locations->type == XR_TYPE_SPACE_LOCATIONS;
}

// A space of another session is passed down as it is: the runtime rejects it.
Side SideIn(const HandleMap<XrSpace, Space>& spaces, const Session& session, XrSpace handle) {
  Side side = SideOf(spaces, handle);
  if (side.session() != &session) side.served_by = kServedByRuntime;
  return side;
}

}  // namespace

XrResult Locator::LocateSpaces(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations) {
  return LocateSpacesThrough(runtime_.next.LocateSpaces, session, info, locations);
}

XrResult Locator::LocateSpacesKHR(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations) {
  return LocateSpacesThrough(runtime_.next.LocateSpacesKHR, session, info, locations);
}

// The application's output is passed down as it is, so that the runtime checks its counts and fills what we do not
// know.
XrResult Locator::LocateSpacesThrough(PFN_xrLocateSpaces below, XrSession session, const XrSpacesLocateInfo* info,
                                      XrSpaceLocations* locations) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  if (!record || !NamesSpaces(info, locations)) return below(session, info, locations);
  const Side base = SideIn(records_.spaces, *record, info->baseSpace);
  const auto is_ours = [&](XrSpace space) { return SideIn(records_.spaces, *record, space).ours(); };
  if (!base.ours() && std::none_of(info->spaces, info->spaces + info->spaceCount, is_ours))
    return below(session, info, locations);

  const PenAt pen = PenAtTime(link_, clock_, *record, info->time);
  std::vector<Side> sides;
  std::vector<XrSpace> asked;
  sides.reserve(info->spaceCount);
  asked.reserve(info->spaceCount);
  for (std::uint32_t i = 0; i < info->spaceCount; ++i) {
    sides.push_back(SideIn(records_.spaces, *record, info->spaces[i]));
    asked.push_back(pen.Below(sides.back()));
  }
  XrSpacesLocateInfo changed = *info;
  changed.baseSpace = pen.Below(base);
  changed.spaces = asked.data();
  const XrResult result = below(session, &changed, locations);
  if (XR_FAILED(result)) return result;

  auto* const velocities = FindInChain<XrSpaceVelocities>(locations->next, XR_TYPE_SPACE_VELOCITIES);
  for (std::uint32_t i = 0; i < info->spaceCount; ++i) {
    if (!base.ours() && !sides[i].ours()) continue;
    XrSpaceLocationData& location = locations->locations[i];
    const LocationFields fields{&location.locationFlags, &location.pose};
    const VelocityFields velocity = FieldsOf(velocities ? &velocities->velocities[i] : nullptr);
    WriteLocation(Between(sides[i], base, FromBelow(fields, velocity, sides[i], base), pen), fields, velocity);
  }
  return result;
}

}  // namespace omni::layer
