// Spaces, and all that is located in one.
//
// Of spaces of the pen, in functions that take an XrSpace: which space the runtime is queried for instead, and how its
// answer is converted (pen_space.cc).
#pragma once

#include <memory>

#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"
#include "layer/src/spaces/locate.h"

namespace omni::layer {

// A space of a call: whose it is, and how far it is from the tool frame.
struct Side {
  XrSpace handle = XR_NULL_HANDLE;
  std::shared_ptr<Space> space;  // null: not made through us
  int served_by = kServedByRuntime;
  Pose X_TS;  // the pen's only
  bool ours() const { return served_by != kServedByRuntime; }
  bool pen() const { return served_by >= 0; }
  const Session* session() const { return space ? space->session.get() : nullptr; }
};

Side SideOf(const HandleMap<XrSpace, Space>& spaces, XrSpace handle);

// The pen at one time in one session: what all spaces of a call share.
struct PenAt {
  XrSpace anchor = XR_NULL_HANDLE;  // L as the runtime knows it; null: the pen has no pose
  BasePose base_pose;
  Motion X_LO;  // the base, at rest unless it follows something
  ToolMotion tool;

  // S in L.
  Located Locate(const Pose& X_TS) const noexcept;
  // The space that the runtime is queried for instead. A space of the pen without a pose stays itself (the runtime's
  // own space behind the handle), so that handles and time are still checked.
  XrSpace Below(const Side& side) const noexcept { return side.pen() && anchor ? anchor : side.handle; }
};

// No runtime call, no system call.
PenAt PenAtTime(const ServiceLink& link, const RuntimeClock& clock, const Session& session, XrTime time);

// Space `s` in space `b`, at least one of them ours, from what the runtime says of their stand-ins.
Located Between(const Side& s, const Side& b, const Located& below, const PenAt& pen) noexcept;

// The runtime's answer. Two spaces that do not move relative to each other have a velocity even if it reports none.
Located FromBelow(const LocationFields& location, const VelocityFields& velocity, const Side& s,
                  const Side& b) noexcept;

class Locator {
 public:
  Locator(const Runtime& runtime, Records& records, ServiceLink& link, const RuntimeClock& clock, Log& log)
      : runtime_(runtime), records_(records), link_(link), clock_(clock), log_(log) {}

  bool Contains(XrHandTrackerEXT tracker) const { return hand_trackers_.Contains(tracker); }
  void EndOf(XrSession session);

  // spaces.cc
  XrResult CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space);
  XrResult CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space);
  XrResult LocateSpace(XrSpace space, XrSpace base, XrTime time, XrSpaceLocation* location);

  // locate_many.cc
  XrResult LocateSpaces(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations);
  XrResult LocateSpacesKHR(XrSession session, const XrSpacesLocateInfo* info, XrSpaceLocations* locations);

  // locate_from_pen.cc
  XrResult LocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* state, uint32_t capacity,
                       uint32_t* count, XrView* views);
  XrResult CreateHandTrackerEXT(XrSession session, const XrHandTrackerCreateInfoEXT* info, XrHandTrackerEXT* tracker);
  XrResult DestroyHandTrackerEXT(XrHandTrackerEXT tracker);
  XrResult LocateHandJointsEXT(XrHandTrackerEXT tracker, const XrHandJointsLocateInfoEXT* info,
                               XrHandJointLocationsEXT* locations);

  // end_frame.cc
  XrResult EndFrame(XrSession session, const XrFrameEndInfo* info);

  // Where a space is in the base frame. Flags are 0 where it is nowhere; errors in space and time are the runtime's.
  XrResult LocateInBase(const Session& session, XrSpace space, XrTime time, Located& X_OS);

  // The spaces of the runtime in which the base may be placed.
  void MakeAnchors(Session& session);

 private:
  XrResult LocateSpacesThrough(PFN_xrLocateSpaces below, XrSession session, const XrSpacesLocateInfo* info,
                               XrSpaceLocations* locations);

  const Runtime& runtime_;
  Records& records_;
  ServiceLink& link_;
  const RuntimeClock& clock_;
  Log& log_;
  HandleMap<XrHandTrackerEXT, Session> hand_trackers_;  // to their sessions
};

}  // namespace omni::layer
