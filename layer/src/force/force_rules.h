// The pure part of XR_OMNIX1_force_feedback: constraints, from the application's structures to the service's message;
// the state that is reported, and which of its changes are events.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/spaces/pose_math.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {

// One constraint as the application set it: point and direction are expressed in `space`.
struct LocalConstraint {
  XrSpace space = XR_NULL_HANDLE;
  protocol::ForceConstraint shape;
};

// XR_ERROR_VALIDATION_FAILURE: a structure outside of the extension's range. Values over what the service takes are
// clamped.
XrResult ReadConstraints(const XrForceFeedbackConstraintsSetInfoOMNIX1& info, std::vector<LocalConstraint>& out);

// The same in the base frame; X_BS: its space there, with the space's velocity.
protocol::ForceConstraint InBase(const protocol::ForceConstraint& shape, const Motion& X_BS) noexcept;

// A vector of the service's messages, within +-limit; zero where not finite.
std::array<double, 3> Clamped(const glm::dvec3& v, double limit) noexcept;

// True: `now` is nothing new to the service, which extrapolates constraints by their velocity.
bool SameConstraints(const protocol::ForceConstraints& sent, const protocol::ForceConstraints& now) noexcept;

struct ForceStatus {
  bool active = false;
  XrForceFeedbackStateFlagsOMNIX1 flags = 0;
  bool operator==(const ForceStatus&) const = default;
};

struct ForceSituation {
  bool focused = false;
  protocol::ForceStanding standing = protocol::ForceStanding::kFree;
  bool fresh = false;                            // a sample arrived within 100 ms
  const protocol::ToolSample* sample = nullptr;  // whose flags count; null: none
};
ForceStatus StatusOf(const ForceSituation& situation) noexcept;

// Bits that flicker with the hand's motion are reported as cleared only after half a second without them.
class ForceStatusWatch {
 public:
  explicit ForceStatusWatch(const ForceStatus& at_first) : reported_(at_first) {}
  // True: there is a change to report, in `reported`.
  bool Step(const ForceStatus& now, std::int64_t now_ns, ForceStatus& reported) noexcept;

 private:
  ForceStatus reported_;
  std::array<std::int64_t, 4> seen_ns_{};
};

}  // namespace omni::layer
