// Spaces, and all that is located in one.
#pragma once

#include "layer/src/instance/runtime.h"
#include "layer/src/spaces/pen_space.h"

namespace omni::layer {

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
