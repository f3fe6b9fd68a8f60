// The currents nearest to wanted ones that fit into the box |I_k| <= I_max_k, in the metric of the force they make.
#pragma once

#include <array>

#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::actuation {

using CurrentArray = std::array<double, base::kCoilCount>;

// H of (I - I0)^T H (I - I0), symmetric: six entries.
struct CurrentMetric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
};

// |W X (I - I0)|^2 with W: errors across the unit vector along `force` count `direction_weight` times those along it
// (force zero: all alike). A millionth of its trace is added to the diagonal, so that there is one minimum even where X
// is singular. docs/theory/actuation.md (12)
CurrentMetric MakeCurrentMetric(const std::array<double, 9>& newton_per_ampere, const base::Vec3& force_N,
                                double direction_weight) noexcept;

// The minimum over the box, exactly: the box's interior, else the best of its 26 faces, edges and corners.
// Precondition: H positive definite, all values finite, limits >= 0.
CurrentArray NearestInBox(const CurrentMetric& H, const CurrentArray& wanted_A, const CurrentArray& max_A) noexcept;

}  // namespace omni::actuation
