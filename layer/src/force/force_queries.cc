// XR_OMNIX1_force_feedback: properties of the device, state of forces, and events about it.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "layer/src/force/force_feedbacks.h"
#include "layer/src/instance/instance.h"
#include "layer/src/spaces/locate.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {

constexpr XrForceFeedbackCapabilityFlagsOMNIX1 kCapabilities = XR_FORCE_FEEDBACK_CAPABILITY_FORCE_3DOF_BIT_OMNIX1 |
                                                               XR_FORCE_FEEDBACK_CAPABILITY_CONSTRAINTS_BIT_OMNIX1 |
                                                               XR_FORCE_FEEDBACK_CAPABILITY_VIBRATION_BIT_OMNIX1;

// X_OW: base z up -> workspace y up, base y (away from the user) -> workspace -z.
Pose WorkspaceInBase() {
  const double h = std::sqrt(0.5);
  return {{0.0, 0.0, 0.0}, glm::dquat(h, h, 0.0, 0.0)};
}

void FillSystem(const protocol::ForceProperties& can, XrSystemForceFeedbackPropertiesOMNIX1& out) {
  const bool there = can.available != 0;
  out.supportsForceFeedback = there ? XR_TRUE : XR_FALSE;
  out.capabilityFlags = there ? kCapabilities : 0;
  out.maxForce = static_cast<float>(can.max_force_N);
  out.maxContinuousForce = static_cast<float>(can.continuous_force_N);
  out.maxStiffness = static_cast<float>(can.max_stiffness_N_m);
  out.maxDamping = static_cast<float>(can.max_damping_Ns_m);
  out.updateRate = static_cast<float>(can.update_rate_Hz);
  out.maxConstraintCount = there ? protocol::kMaxForceConstraints : 0;
}

void FillReach(const protocol::ForceProperties& can, XrForceFeedbackPropertiesOMNIX1& out) {
  out.reachCountOutput = can.reach_count;
  if (out.reachCapacityInput == 0) return;
  for (std::uint32_t i = 0; i < can.reach_count; ++i) {
    out.reach[i] = {static_cast<float>(can.reach[i].distance_m), static_cast<float>(can.reach[i].force_N)};
  }
}

// What both queries reject: structures of other types, no space, no time.
template <class GetInfo, class Out>
XrResult CheckQuery(const GetInfo* info, XrStructureType info_type, const Out* out, XrStructureType out_type) {
  if (!info || info->type != info_type || !out || out->type != out_type) return XR_ERROR_VALIDATION_FAILURE;
  if (info->baseSpace == XR_NULL_HANDLE) return XR_ERROR_HANDLE_INVALID;
  return info->time > 0 ? XR_SUCCESS : XR_ERROR_TIME_INVALID;
}

}  // namespace

// The next layer never sees our structures.
XrResult Instance::GetSystemProperties(XrSystemId system, XrSystemProperties* properties) {
  KeepAlive();
  if (!properties || !runtime.HasExtension(XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME))
    return runtime.next.GetSystemProperties(runtime.handle, system, properties);
  auto* before = reinterpret_cast<XrBaseOutStructure*>(properties);
  while (before->next && before->next->type != XR_TYPE_SYSTEM_FORCE_FEEDBACK_PROPERTIES_OMNIX1) before = before->next;
  XrBaseOutStructure* ours = before->next;
  if (!ours) return runtime.next.GetSystemProperties(runtime.handle, system, properties);
  before->next = ours->next;
  const XrResult result = runtime.next.GetSystemProperties(runtime.handle, system, properties);
  before->next = ours;
  if (XR_FAILED(result)) return result;
  link.AwaitForceProperties();  // often called right after xrCreateInstance, before the service has answered
  FillSystem(link.force_properties(), *reinterpret_cast<XrSystemForceFeedbackPropertiesOMNIX1*>(ours));
  return result;
}

XrResult ForceFeedbacks::GetProperties(XrForceFeedbackOMNIX1 handle_in,
                                       const XrForceFeedbackPropertiesGetInfoOMNIX1* info,
                                       XrForceFeedbackPropertiesOMNIX1* properties) {
  const auto force = forces_.Find(handle_in);
  if (!force) return XR_ERROR_HANDLE_INVALID;
  if (const XrResult result = CheckQuery(info, XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1, properties,
                                         XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1);
      XR_FAILED(result))
    return result;
  if (properties->reachCapacityInput > 0 && !properties->reach) return XR_ERROR_VALIDATION_FAILURE;
  const protocol::ForceProperties can = link_.force_properties();
  if (can.available == 0) return XR_ERROR_FEATURE_UNSUPPORTED;
  Located X_OS;
  if (const XrResult result = locator_.LocateInBase(*force->session, info->baseSpace, info->time, X_OS);
      XR_FAILED(result))
    return result;
  const bool fits = properties->reachCapacityInput == 0 || properties->reachCapacityInput >= can.reach_count;
  if (!fits) {
    properties->reachCountOutput = can.reach_count;
    return XR_ERROR_SIZE_INSUFFICIENT;
  }
  Located workspace;
  workspace.motion.X = WorkspaceInBase();
  workspace.flags = kValid | kTracked;
  WriteLocation(Compose(Inverse(X_OS), workspace), {&properties->workspaceLocationFlags, &properties->workspacePose},
                {});
  properties->innerRadius = static_cast<float>(can.inner_radius_m);
  properties->outerRadius = static_cast<float>(can.outer_radius_m);
  if (!fits) return XR_ERROR_SIZE_INSUFFICIENT;
  FillReach(can, *properties);
  return XR_SUCCESS;
}

XrResult ForceFeedbacks::GetState(XrForceFeedbackOMNIX1 handle_in, const XrForceFeedbackStateGetInfoOMNIX1* info,
                                  XrForceFeedbackStateOMNIX1* state) {
  const auto force = forces_.Find(handle_in);
  if (!force) return XR_ERROR_HANDLE_INVALID;
  if (const XrResult result =
          CheckQuery(info, XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, state, XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1);
      XR_FAILED(result))
    return result;
  Located X_OS;
  if (const XrResult result = locator_.LocateInBase(*force->session, info->baseSpace, info->time, X_OS);
      XR_FAILED(result))
    return result;
  protocol::ToolSample newest;
  protocol::ToolSample then;
  protocol::ToolSample after;
  const auto reader = link_.reader();
  const std::int64_t time_ns = clock_.ToMonotonic(info->time);
  const bool any = reader && reader->ReadNewest(newest) && reader->ReadAround(time_ns, then, after);
  const ForceStatus status = StatusOf({.focused = force->session->focused,
                                       .standing = link_.force_standing(),
                                       .fresh = any && base::MonotonicNow_ns() - newest.t_ns <= kPresenceTimeout_ns,
                                       .sample = any ? &then : nullptr});
  state->isActive = status.active ? XR_TRUE : XR_FALSE;
  state->stateFlags = status.flags;
  state->sampleTime = any ? clock_.ToXr(then.t_ns) : 0;
  state->contactCount = any ? then.contact_count : 0;
  state->isForceValid = any && (X_OS.flags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) ? XR_TRUE : XR_FALSE;
  state->appliedForce = {0, 0, 0};
  if (state->isForceValid) {
    const glm::dvec3 f_O(then.force_base_N[0], then.force_base_N[1], then.force_base_N[2]);
    state->appliedForce = ToXr(glm::conjugate(X_OS.motion.X.q) * f_O);
  }
  return XR_SUCCESS;
}

ForceStatus ForceFeedbacks::StatusNow(const Session& session) {
  protocol::ToolSample newest;
  const auto reader = link_.reader();
  const bool any = reader && reader->ReadNewest(newest);
  return StatusOf({.focused = session.focused,
                   .standing = link_.force_standing(),
                   .fresh = any && base::MonotonicNow_ns() - newest.t_ns <= kPresenceTimeout_ns,
                   .sample = any ? &newest : nullptr});
}

void ForceFeedbacks::QueueStateEvents() {
  for (const auto& force : forces_.Values()) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    const ForceStatus now = StatusNow(*force->session);
    ForceStatus reported;
    {
      const std::lock_guard lock(force->mutex);
      if (!force->watch.Step(now, now_ns, reported)) continue;
    }
    events_.Push(XrEventDataForceFeedbackStateChangedOMNIX1{
        XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1, nullptr, force->session->handle, force->handle(),
        static_cast<XrBool32>(reported.active), reported.flags, clock_.ToXr(now_ns)});
  }
}

bool ForceFeedbacks::IsOfDestroyed(const XrEventDataBuffer& event) const {
  if (event.type != XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1) return false;
  XrEventDataForceFeedbackStateChangedOMNIX1 changed;
  std::memcpy(&changed, &event, sizeof(changed));
  return !forces_.Contains(changed.forceFeedback);
}

}  // namespace omni::layer
