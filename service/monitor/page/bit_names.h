// Bits that the page receives, by name. service/page/src/contract.ts is printed from these tables.
#pragma once

#include <cstdint>
#include <span>

namespace omni::monitor {

struct BitName {
  std::uint32_t mask;     // one bit
  const char* name;       // an identifier
  const char* text = "";  // what people read, if they ever do
};

std::span<const BitName> FlagNames() noexcept;       // protocol::ToolSample::flags
std::span<const BitName> TickFaultNames() noexcept;  // loop::TickFault, of the channel "tick_faults"
std::span<const BitName> ToolLimitNames() noexcept;  // base::ToolLimit, of the channel "tool_limits"

}  // namespace omni::monitor
