#include "layer/src/force/force_state.h"

namespace omni::layer {
namespace {

std::int64_t GoneAfter_ns() noexcept { return 500'000'000; }

struct SampleBit {
  std::uint32_t sample;
  XrForceFeedbackStateFlagsOMNIX1 state;
};
constexpr std::array<SampleBit, 5> kSampleBits{{
    {protocol::kToolForceCut, XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1},
    {protocol::kToolWarm, XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1},
    {protocol::kToolOutOfReach, XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1},
    {protocol::kToolDeviceFault, XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1},
    {protocol::kToolStiffnessLimited, XR_FORCE_FEEDBACK_STATE_STIFFNESS_LIMITED_BIT_OMNIX1},
}};
// Those that flicker with the hand's motion.
constexpr std::array<XrForceFeedbackStateFlagsOMNIX1, 4> kFleeting{
    XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1, XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1,
    XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1, XR_FORCE_FEEDBACK_STATE_STIFFNESS_LIMITED_BIT_OMNIX1};

}  // namespace

ForceStatus StatusOf(const ForceSituation& situation) noexcept {
  ForceStatus status;
  const bool fresh = situation.fresh && situation.sample;
  if (!situation.focused) status.flags |= XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1;
  if (!fresh) status.flags |= XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1;
  if (situation.standing == protocol::ForceStanding::kTaken) status.flags |= XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1;
  if (situation.sample)
    for (const SampleBit& bit : kSampleBits)
      if (situation.sample->flags & bit.sample) status.flags |= bit.state;
  status.active = situation.focused && fresh && situation.standing == protocol::ForceStanding::kYours &&
                  !(status.flags & XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1);
  return status;
}

bool ForceStatusWatch::Step(const ForceStatus& now, std::int64_t now_ns, ForceStatus& reported) noexcept {
  ForceStatus status = now;
  for (std::size_t i = 0; i < kFleeting.size(); ++i) {
    if (now.flags & kFleeting[i]) seen_ns_[i] = now_ns;
    if (now_ns - seen_ns_[i] < GoneAfter_ns()) status.flags |= reported_.flags & kFleeting[i];
  }
  if (status == reported_) return false;
  reported = reported_ = status;
  return true;
}

}  // namespace omni::layer
