// The part of the tick's state that deforms and moves surfaces, for drawing (base::Latest). Written on the tick's
// thread, seldom, and only while a client reads: a copy of fixed size, no allocation, no lock.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/clock.h"
#include "service/loop/tick.h"

namespace omni::loop {

inline constexpr std::int64_t kSurfacePeriod_ns = 8'000'000;  // at most 125 times a second

struct SurfaceSnapshot {
  std::uint64_t scene_generation = 0;  // of the scene that the rest is about
  std::int64_t t_ns = 0;               // of the scan; 0: nothing was written yet
  std::array<haptics::SoftTouch, haptics::kMaxContacts> soft;
  std::array<haptics::RegionState, haptics::kMaxRegions> regions;
  std::array<haptics::MovedObject, haptics::kMaxMoved> moved;
};
static_assert(std::is_trivially_copyable_v<SurfaceSnapshot>);

// True: the last snapshot, of `last_ns`, is old enough, or time went back.
inline bool SnapshotIsDue(std::int64_t t_ns, std::int64_t last_ns) noexcept {
  const std::int64_t age_ns = base::StampDifference_ns(t_ns, last_ns);
  return !(age_ns >= 0 && age_ns < kSurfacePeriod_ns);
}

// Of the soft bodies only those that are touched are copied: a free slot keeps its old body, but is marked as free.
inline void FillSurfaceSnapshot(const LoopState& state, SurfaceSnapshot& snapshot) noexcept {
  snapshot.scene_generation = state.scene_generation;
  snapshot.t_ns = state.t_ns;
  for (std::size_t k = 0; k < snapshot.soft.size(); ++k) {
    snapshot.soft[k].object = state.haptics.soft[k].object;
    if (snapshot.soft[k].object != haptics::kNoIndex) snapshot.soft[k].body = state.haptics.soft[k].body;
  }
  snapshot.regions = state.haptics.regions;
  snapshot.moved = state.haptics.moved;
}

}  // namespace omni::loop
