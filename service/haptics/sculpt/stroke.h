// What a stroke does, how the tick sends it to the editor, and what the tick remembers of it.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/handover.h"
#include "service/base/vec.h"

namespace omni::haptics::sculpt {

using base::Vec3;

// Share of the offset over the distance s = geodesic distance / radius.   (3.1)
enum class Falloff : std::uint8_t {
  kConstant = 0,  // 1, and a smooth rim over the outer fifth
  kLinear = 1,    // 1 - s
  kSmooth = 2,    // 1 - 3 s^2 + 2 s^3
};

inline double FalloffShare(Falloff falloff, double s) noexcept {
  constexpr double kRim = 0.2;
  if (!(s < 1)) return 0;
  if (falloff == Falloff::kLinear) return 1 - s;
  const double x = falloff == Falloff::kConstant ? std::max(0.0, (s - (1 - kRim)) / kRim) : s;
  return 1 - x * x * (3 - 2 * x);
}

struct SymmetryPlane {
  bool enabled = false;
  Vec3 point_base_m;
  Vec3 normal{1, 0, 0};  // any length but 0
};

struct Brush {
  double radius_m = 0.005;  // (0, 1], along the surface
  Falloff falloff = Falloff::kSmooth;
  SymmetryPlane symmetry;
};
static_assert(std::is_trivially_copyable_v<Brush>);

// Messages from the tick to the editor, of fixed size, and the lock-free ring that carries them.
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

// What the tick remembers of sculpting: sculpt_tool.h.
enum class SculptPhase : std::uint8_t { kFree = 0, kPressed = 1, kHeld = 2, kSettling = 3 };

// Whether the tip rests: its smoothed height stays where it was.
struct TipRest {
  double height_m = 0;       // over the grip, smoothed
  double rested_s = 0;       // that it has stayed ...
  double rest_height_m = 0;  // ... here
};

struct SculptToolState {
  SculptPhase phase = SculptPhase::kFree;
  bool armed = true;  // a new grab needs the pen to have let off since the last
  double timer_s = 0;
  std::array<TipRest, 2> rests;  // of a still hand, and of one that trembles
  Vec3 grip_base_m;              // tip when taken
  Vec3 normal;                   // of the surface when taken
  double start_force_N = 0;
  double offset_m = 0;         // that the surface has been moved so far
  double hold = 0;             // share of the tool's force, the contact has the rest
  Vec3 held_force_N;           // the tool's force at the last tick it held
  std::uint32_t stroke = 0;    // counts up
  std::uint32_t releases = 0;  // as they were when it was taken
  double sent_offset_m = 0;
  bool begin_waits = false;  // messages that did not fit the ring yet
  bool end_waits = false;
  StrokeMessage begin;
};
static_assert(std::is_trivially_copyable_v<SculptToolState>);

}  // namespace omni::haptics::sculpt
