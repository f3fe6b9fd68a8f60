#include "service/loop/scene_memory.h"

#include <algorithm>

namespace omni::loop {
namespace {

// It is no longer held: it settles to the next step, like one that was released.
haptics::RegionState LetGo(const haptics::RegionState& region) noexcept {
  const bool rests = region.phase == haptics::ExtrudePhase::kFree;
  return {.phase = rests ? haptics::ExtrudePhase::kFree : haptics::ExtrudePhase::kSettling,
          .offset_m = region.offset_m,
          .step = region.step,
          .edits = region.edits,
          .last_offset_m = region.offset_m};
}

// It waits where it was, and its lap with it.
haptics::VehicleState Parked(const haptics::VehicleState& vehicle) noexcept {
  haptics::VehicleState parked;
  parked.started = vehicle.started;
  parked.position_base_m = vehicle.position_base_m;
  parked.heading_rad = vehicle.heading_rad;
  parked.hits = vehicle.hits;
  parked.hit_speed_m_s = vehicle.hit_speed_m_s;
  parked.lap = vehicle.lap;
  return parked;
}

}  // namespace

void SceneMemory::SaveState(std::uint64_t build, const haptics::State& state) noexcept {
  if (build == 0) return;
  auto place = std::find_if(left_.begin(), left_.end(), [build](const Left& left) { return left.build == build; });
  if (place == left_.end()) {
    place = std::min_element(left_.begin(), left_.end(), [](const Left& a, const Left& b) { return a.kept < b.kept; });
  }
  place->build = build;
  place->kept = ++kept_;
  std::transform(state.regions.begin(), state.regions.end(), place->regions.begin(), LetGo);
  place->vehicle = Parked(state.vehicle);
}

void SceneMemory::RestoreState(std::uint64_t build, haptics::State& state) const noexcept {
  if (build == 0) return;
  const auto found =
      std::find_if(left_.begin(), left_.end(), [build](const Left& left) { return left.build == build; });
  if (found == left_.end()) return;
  state.regions = found->regions;
  state.vehicle = found->vehicle;
  state.appears = false;  // the pen knows it: a wall that was pressed before a menu is there after it
}

}  // namespace omni::loop
