// Spaces of the pen in functions that take an XrSpace: which space the runtime is queried for instead, and how its
// answer is converted.
#pragma once

#include <memory>

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

}  // namespace omni::layer
