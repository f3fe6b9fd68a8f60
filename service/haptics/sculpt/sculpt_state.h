// What the tick remembers of sculpting: sculpt_tool.h.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/haptics/sculpt/stroke.h"

namespace omni::haptics::sculpt {

enum class SculptPhase : std::uint8_t { kFree = 0, kPressed = 1, kHeld = 2, kSettling = 3 };

struct SculptToolState {
  SculptPhase phase = SculptPhase::kFree;
  bool armed = true;  // a new grab needs the pen to have let off since the last
  double timer_s = 0;
  double height_m = 0;       // of the tip over the grip, smoothed
  double rested_s = 0;       // that it has stayed ...
  double rest_height_m = 0;  // ... here
  Vec3 grip_base_m;          // tip when taken
  Vec3 normal;               // of the surface when taken
  double start_force_N = 0;
  double offset_m = 0;       // that the surface has been moved so far
  double hold = 0;           // share of the tool's force, the contact has the rest
  Vec3 held_force_N;         // the tool's force at the last tick it held
  std::uint32_t stroke = 0;  // counts up
  double sent_offset_m = 0;
  bool begin_waits = false;  // messages that did not fit the ring yet
  bool end_waits = false;
  StrokeMessage begin;
};
static_assert(std::is_trivially_copyable_v<SculptToolState>);

}  // namespace omni::haptics::sculpt
