// How long a base may act on a COMMAND of ours when no other one follows.
#pragma once

#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::device {

// A silent host must have left no current 20 ms after its last COMMAND: this life, the control step that finds it over
// (0.25 ms), a ramp of at most 5 ms, and the coils' own lag. The table "Silence" of docs/protocol/faults.md has it
// measured. At 1 kHz eleven commands in a row may come late or not at all before the base disarms; a force held for
// longer than that would be a wrong one anyway. docs/decisions/0010
constexpr std::uint16_t kCommandTimeToLive_ms = 12;

// Zero leaves nothing to take away and may live as long as the wire allows: the base of a service that rests, and so
// speaks every 16 ms, stays armed.
constexpr std::uint16_t TimeToLive_ms(const float (&set_point_A)[wire::kCoils]) noexcept {
  for (const float current_A : set_point_A) {
    if (current_A != 0) return kCommandTimeToLive_ms;
  }
  return wire::kTimeToLiveMax_ms;
}
static_assert(kCommandTimeToLive_ms >= 1 && kCommandTimeToLive_ms <= wire::kTimeToLiveMax_ms, "range of the wire");

}  // namespace omni::device
