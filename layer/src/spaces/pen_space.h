// The spaces that are the pen's, as the functions that take an XrSpace see them: what the runtime is asked instead, and
// what is made of its answer.
#pragma once

#include <memory>

#include "layer/src/instance/instance.h"
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

Side SideOf(const Instance& instance, XrSpace handle);

// The pen at one time in one session: what all spaces of a call share.
struct PenAt {
  XrSpace anchor = XR_NULL_HANDLE;  // L as the runtime knows it; null: the pen has no pose
  BasePose placement;
  ToolMotion tool;

  // S in L.
  Located Locate(const Pose& X_TS) const noexcept;
  // What the runtime is asked about in place of a space. Ours without a pose stay themselves: the runtime's own space
  // behind the handle, so that handles and time are checked all the same.
  XrSpace Below(const Side& side) const noexcept { return side.pen() && anchor ? anchor : side.handle; }
};

// No call below, no system call.
PenAt PenAtTime(const Instance& instance, const Session& session, XrTime time);

// Space `s` in space `b`, at least one of them ours, from what the runtime says of their stand-ins.
Located Between(const Side& s, const Side& b, const Located& below, const PenAt& pen) noexcept;

// The runtime's answer. Two spaces that do not move against each other have a velocity even if it names none.
Located FromBelow(const LocationFields& location, const VelocityFields& velocity, const Side& s,
                  const Side& b) noexcept;

}  // namespace omni::layer
