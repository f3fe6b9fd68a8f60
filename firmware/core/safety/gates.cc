#include "firmware/core/safety/gates.h"

#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {
namespace {

constexpr std::uint64_t kNonceLife_us = 100'000;

// A counter through MurmurHash3's final mix: neighbours have nothing in common. Not a secret; the bus is trusted,
// frames are not.
std::uint32_t Mix(std::uint32_t value) noexcept {
  value ^= value >> 16;
  value *= 0x85EBCA6BU;
  value ^= value >> 13;
  value *= 0xC2B2AE35U;
  return value ^ (value >> 16);
}

}  // namespace

std::uint32_t Arming::Challenge(std::uint64_t now_us) noexcept {
  do {
    state_ += 0x9E3779B9U;
    nonce_ = Mix(state_);
  } while (nonce_ == 0);  // 0 is the nonce of an empty confirmation
  asked_us_ = now_us;
  is_open_ = true;
  return nonce_;
}

bool Arming::Confirm(std::uint32_t nonce, std::uint64_t now_us) noexcept {
  const bool is_right = is_open_ && nonce == nonce_ && now_us - asked_us_ <= kNonceLife_us;
  is_open_ = false;
  return is_right;
}

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

bool OutputCheck::Allows(const Outputs& outputs) noexcept {
  const bool is_ramp = left_steps_ > 0;
  if (is_ramp) --left_steps_;
  if (state_ == wire::State::kArmed) left_steps_ = kRamp_steps;
  if (is_ramp || state_ == wire::State::kArmed || state_ == wire::State::kSelfTest) return true;
  for (const std::int16_t duty : outputs.duty) {
    if (duty != 0) return false;
  }
  return true;
}

}  // namespace omni::firmware
