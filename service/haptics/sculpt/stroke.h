// Messages from the tick to the editor, of fixed size, and the lock-free ring that carries them.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/spsc_ring.h"
#include "service/haptics/sculpt/brush.h"

namespace omni::haptics::sculpt {

enum class StrokeKind : std::uint8_t { kBegin = 0, kMove = 1, kEnd = 2 };

// Offsets are absolute since kBegin, so that a move that was lost or left out is made good by the next.
struct StrokeMessage {
  StrokeKind kind = StrokeKind::kMove;
  std::uint32_t stroke = 0;    // counts up from 1; the same from kBegin to kEnd
  std::uint32_t triangle = 0;  // kBegin: where the surface was taken, in `generation` ...
  std::uint64_t generation = 0;
  std::array<double, 3> weights{};  // ... barycentric ...
  Vec3 point_base_m;                // ... and as a point
  Brush brush;                      // kBegin
  double offset_m = 0;              // along the region's mean normal, > 0: out
};
static_assert(std::is_trivially_copyable_v<StrokeMessage>);

// At most one message per tick: room for half a second.
using StrokeRing = base::SpscRing<StrokeMessage, 512>;

}  // namespace omni::haptics::sculpt
