// How long a base may act on a COMMAND of this host when no other one follows.
#pragma once

#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::device {

// 20 ms after a silent host's last COMMAND no current may be left: this life, the control step that detects its end
// (0.25 ms), a ramp of at most 5 ms, and the coils' own lag; measured in the table "Silence" of
// docs/protocol/faults.md. At 1 kHz eleven commands in a row may be late or lost before the base disarms; a force held
// for longer than that would be a wrong one anyway. docs/decisions/0010
constexpr std::uint16_t kCommandTimeToLive_ms = 12;

// A zero current may live as long as the wire allows, for there is nothing to remove: the base of a service that rests,
// and therefore sends only every 16 ms, stays armed.
constexpr std::uint16_t TimeToLive_ms(const float (&set_point_A)[wire::kCoils]) noexcept {
  for (const float current_A : set_point_A) {
    if (current_A != 0) return kCommandTimeToLive_ms;
  }
  return wire::kTimeToLiveMax_ms;
}
static_assert(kCommandTimeToLive_ms >= 1 && kCommandTimeToLive_ms <= wire::kTimeToLiveMax_ms, "range of the wire");

}  // namespace omni::device
