#include "service/monitor/page/bit_names.h"

#include <array>
#include <utility>

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
constexpr const char* NameOf(base::ToolLimit limit) noexcept {
  switch (limit) {
    case base::kToolTilted:
      return "tilted";
    case base::kToolCoarse:
      return "coarse";
    case base::kToolFewReadings:
      return "few_readings";
    case base::kToolSensorSaturated:
      return "sensor_saturated";
    case base::kToolContradicted:
      return "contradicted";
    case base::kToolRepeated:
      return "repeated";
    case base::kToolFrozen:
      return "frozen";
  }
  return nullptr;
}
template <std::size_t... kBit>
constexpr auto NamesOfBits(std::index_sequence<kBit...>) noexcept {
  constexpr std::size_t kCount = ((NameOf(static_cast<base::ToolLimit>(1U << kBit)) != nullptr ? 1 : 0) + ...);
  std::array<BitName, kCount> names{};
  for (std::uint32_t i = 0; i < kCount; ++i) names[i] = {1U << i, NameOf(static_cast<base::ToolLimit>(1U << i))};
  return names;
}
constexpr auto kToolLimits = NamesOfBits(std::make_index_sequence<32>());

}  // namespace

std::span<const BitName> FlagNames() noexcept { return kFlags; }
std::span<const BitName> TickFaultNames() noexcept { return kTickFaults; }
std::span<const BitName> ToolLimitNames() noexcept { return kToolLimits; }

}  // namespace omni::monitor
