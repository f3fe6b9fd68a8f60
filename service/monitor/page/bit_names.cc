#include "service/monitor/page/bit_names.h"

#include <array>

#include "service/base/tool_state.h"
#include "service/protocol/state_memory.h"

namespace omni::monitor {
namespace {

constexpr auto kFlags = std::to_array<BitName>({
    {protocol::kToolPoseValid, "pose_valid"},
    {protocol::kToolTracked, "tracked"},
    {protocol::kToolContact, "contact"},
    {protocol::kToolJoystick, "joystick"},
    {protocol::kToolAligned, "aligned"},
    {protocol::kToolPushed, "pushed"},
    {protocol::kToolForceCut, "saturated"},
    {protocol::kToolWarm, "warm"},
    {protocol::kToolOutOfReach, "out_of_reach"},
    {protocol::kToolDeviceFault, "device_fault"},
    {protocol::kToolStiffnessLimited, "stiffness_limited"},
    {protocol::kToolHolding, "holding"},
    {protocol::kToolSoftened, "softened"},
    {protocol::kToolWaits, "waits"},
});
constexpr auto kTickFaults = std::to_array<BitName>({
    {1, "device", "the device reports faults"},
    {2, "tracking", "the pen is not tracked"},
    {4, "time", "time stamps went back or jumped"},
    {8, "not_finite", "a result was not finite: currents are zero"},
    {16, "commands_stale", "commands are stale"},
});
constexpr auto kToolLimits = std::to_array<BitName>({
    {base::kToolTilted, "tilted"},
    {base::kToolCoarse, "coarse"},
    {base::kToolFewReadings, "few_readings"},
    {base::kToolSensorSaturated, "sensor_saturated"},
    {base::kToolContradicted, "contradicted"},
    {base::kToolRepeated, "repeated"},
    {base::kToolFrozen, "frozen"},
});

}  // namespace

std::span<const BitName> FlagNames() noexcept { return kFlags; }
std::span<const BitName> TickFaultNames() noexcept { return kTickFaults; }
std::span<const BitName> ToolLimitNames() noexcept { return kToolLimits; }

}  // namespace omni::monitor
