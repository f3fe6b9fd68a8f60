// The state of forces that XR_OMNIX1_force_feedback reports, and which changes are events. Pure.
#pragma once

#include <array>
#include <cstdint>

#include "layer/include/openxr/omni_force_feedback.h"
#include "service/protocol/force_feedback.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {

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
