// What XR_OMNIX1_force_feedback says of the state of forces, and when a change is worth an event. Pure.
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
  bool fresh = false;                            // the device was heard of within 100 ms
  const protocol::ToolSample* sample = nullptr;  // whose flags count; null: none
};
ForceStatus StatusOf(const ForceSituation& situation) noexcept;

// Bits that come and go with the hand are told to be gone only after half a second without them.
class ForceStatusWatch {
 public:
  explicit ForceStatusWatch(const ForceStatus& at_first) : told_(at_first) {}
  // True: `told` is another one than the last that was told.
  bool Step(const ForceStatus& now, std::int64_t now_ns, ForceStatus& told) noexcept;

 private:
  ForceStatus told_;
  std::array<std::int64_t, 4> seen_ns_{};
};

}  // namespace omni::layer
