// The valid range of a sample. The writer publishes nothing else, and readers accept nothing else: whatever the shared
// memory holds, no NaN and no absurd number reaches an application.
#pragma once

#include "service/protocol/state_memory.h"

namespace omni::protocol {

inline constexpr double kLargestValue = 1e6;                           // of any SI value in a sample
inline constexpr std::int64_t kLatestTime_ns = std::int64_t{1} << 62;  // differences of two times cannot overflow
inline constexpr double kUnitTolerance = 1e-2;                         // of |q|^2

// The compiler names a flag that is missing here.
constexpr bool IsKnown(ToolFlag flag) noexcept {
  switch (flag) {
    case kToolPoseValid:
    case kToolTracked:
    case kToolContact:
    case kToolJoystick:
    case kToolAligned:
    case kToolPushed:
    case kToolForceCut:
    case kToolWarm:
    case kToolOutOfReach:
    case kToolDeviceFault:
    case kToolStiffnessLimited:
    case kToolHolding:
    case kToolSoftened:
    case kToolWaits:
      return true;
  }
  return false;
}
inline constexpr std::uint32_t kKnownToolFlags = [] {
  std::uint32_t flags = 0;
  for (std::uint32_t bit = 1; bit != 0; bit <<= 1) flags |= IsKnown(static_cast<ToolFlag>(bit)) ? bit : 0;
  return flags;
}();
static_assert(kStateVersion == 5 && kKnownToolFlags == 0x3FFF,
              "readers of the same version refuse a flag that they do not know: both change together");
inline constexpr std::uint32_t kKnownBaseFlags = kBaseSeen | kBaseLeapt;

bool InRange(const ToolSample& sample) noexcept;
bool InRange(const BaseSample& sample) noexcept;
bool InRange(const InputSnapshot& inputs) noexcept;
bool InRange(const ContactSnapshot& contacts) noexcept;
bool InRange(const VehicleSnapshot& vehicle) noexcept;
bool InRange(const TelemetrySample& telemetry) noexcept;

// The sample itself if it is in range. Else: gap and sigma are clamped; if that does not help, there is no pose
// (pose flags cleared, numbers at their defaults; time, joystick and alignment flags stay).
ToolSample Clamped(const ToolSample& sample) noexcept;
// Values are clamped to [-1, 1] (NaN to 0), times to [0, kLatestTime_ns].
InputSnapshot Clamped(const InputSnapshot& inputs) noexcept;
// Contacts that are out of range are omitted.
ContactSnapshot Clamped(const ContactSnapshot& contacts) noexcept;
// Out of range: there is no car.
VehicleSnapshot Clamped(const VehicleSnapshot& vehicle) noexcept;
// Values are clamped to +-kLargestValue (NaN to 0).
TelemetrySample Clamped(const TelemetrySample& telemetry) noexcept;

}  // namespace omni::protocol
