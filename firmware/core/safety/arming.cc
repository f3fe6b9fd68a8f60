#include "firmware/core/safety/arming.h"

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

}  // namespace omni::firmware
