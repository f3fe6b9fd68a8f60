// Keeps what the user has made of a scene while it is not active: a menu takes the focus away, no scene or another one
// is active, and the scene comes back as it was left. Extruded faces, the car and its laps; sculpted surfaces live in
// sculpt sessions of their own. The tick's thread only.
#pragma once

#include <array>
#include <cstdint>

#include "service/haptics/state.h"

namespace omni::loop {

inline constexpr int kRememberedScenes = 4;  // a further one replaces the one that was left first

class SceneMemory {
 public:
  // `build`: of the scene of `state`; 0: one that never comes back.
  void SaveState(std::uint64_t build, const haptics::State& state) noexcept;
  // After haptics::Enter. A scene that is not remembered stays as it was built.
  void RestoreState(std::uint64_t build, haptics::State& state) const noexcept;

 private:
  struct Left {
    std::uint64_t build = 0;
    std::uint64_t kept = 0;  // running number
    std::array<haptics::RegionState, haptics::kMaxRegions> regions;
    haptics::VehicleState vehicle;
  };
  std::array<Left, kRememberedScenes> left_;
  std::uint64_t kept_ = 0;
};

}  // namespace omni::loop
