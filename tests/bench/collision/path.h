// Paths of a tip over a body at 1 kHz.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/collision/oracle.h"

namespace omni::collision {

struct Style {
  const char* name;
  double step_m;               // the tip moves so far in a tick
  double lowest_m, highest_m;  // height over the surface; 0: the deepest that is allowed
  double wave_m;               // path along the surface per up and down
};

inline constexpr Style kStyles[] = {{"slow", 1e-4, 0, 2e-3, 40e-3},
                                    {"fast", 6e-4, 0, 2e-3, 40e-3},
                                    {"tap", 2e-4, -0.6e-3, 1.0e-3, 4e-3},
                                    {"hold", 1e-4, -0.9e-3, -0.1e-3, 10e-3}};
inline constexpr double kDeepest = 0.3;      // of the local thickness: exact length of the ray inwards
inline constexpr double kDeepest_m = 0.005;  // where 400 N/m give the 2 N that the device has

// `ticks` places; starts outside or, where the style never leaves, inside.
std::vector<Vec3> MakePath(const Body& body, const Oracle& oracle, const Style& style, std::size_t ticks,
                           std::uint64_t seed);

}  // namespace omni::collision
