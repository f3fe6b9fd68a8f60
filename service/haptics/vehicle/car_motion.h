// Where the car goes in a tick: straight on until a wall, then off it or along it, as often as it takes. It never
// passes a wall, at any speed. docs/theory/haptics.md, section 8.
#pragma once

#include "service/haptics/state.h"
#include "service/haptics/vehicle/wall_map.h"

namespace omni::haptics {

inline constexpr int kMaxImpacts = 4;  // rendered in one tick; further ones are only counted

struct Impact {
  double speed_m_s = 0;  // into the wall
  Vec3 normal;           // unit, away from the wall
  double restitution = 0;
};

struct Impacts {
  int count = 0;
  std::array<Impact, kMaxImpacts> of;
};

// Moves the car by its velocity. Walls take out the part into them (give back `restitution` of it at a hit), and turn
// the nose along the wall; energy is never gained. A wall it leans on already is no further hit.
Impacts MoveCar(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials, double dt_s,
                VehicleState& state) noexcept;

}  // namespace omni::haptics
