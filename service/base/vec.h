// Plain vectors for the seams: trivially copyable, no alignment rules, so that they can live in shared
// memory, rings and hashes. Physics code works in Eigen (see eigen.h) and converts at its edge.
#pragma once

#include <array>
#include <type_traits>

namespace omni::base {

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

// Unit quaternion, Hamilton convention, rotates from the named child frame to the parent frame.
struct Quat {
  double w = 1;
  double x = 0;
  double y = 0;
  double z = 0;
  friend bool operator==(const Quat&, const Quat&) = default;
};

static_assert(std::is_trivially_copyable_v<Vec3> && std::is_trivially_copyable_v<Quat>);

}  // namespace omni::base
