#include "firmware/core/safety/command_gate.h"

namespace omni::firmware {

bool CommandGate::Accept(const wire::Command& command, std::uint16_t seq, std::uint64_t now_us) noexcept {
  const bool is_newer = wire::SeqDistance(seq_, seq) > 0 && command.host_us >= host_us_;
  if (has_order_ && !is_newer) return false;
  has_order_ = has_life_ = true;
  seq_ = seq;
  host_us_ = command.host_us;
  heard_us_ = now_us;
  live_us_ = std::uint64_t{1000} * command.time_to_live_ms;
  return true;
}

void CommandGate::StartWaiting(std::uint64_t now_us) noexcept {
  has_life_ = true;
  heard_us_ = now_us;
  live_us_ = std::uint64_t{1000} * wire::kTimeToLiveMax_ms;
}

}  // namespace omni::firmware
