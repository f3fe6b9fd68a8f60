// Force to currents: the inverse of the force map, damped where one direction cannot be pushed.
#pragma once

#include <array>

namespace omni::actuation {

struct DampedInverse {
  bool valid = false;                         // false: X is zero or not finite, all zero
  bool damped = false;                        // conditioning < singular_ratio: one direction fades out
  double conditioning = 0;                    // smallest over largest singular value
  std::array<double, 9> ampere_per_newton{};  // row-major 3x3
};
// docs/theory/actuation.md (3.1)
DampedInverse InvertForceMap(const std::array<double, 9>& newton_per_ampere, double singular_ratio) noexcept;

}  // namespace omni::actuation
