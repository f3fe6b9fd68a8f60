// A coil of the base: a band of circular turns on spherical shells around the iron core. Set-up only: allocates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "service/base/device_geometry.h"

namespace omni::magnetics {

// One turn, at height_m along the coil's axis.
struct Turn {
  double radius_m = 0;
  double height_m = 0;
};

// Turns of coil `index` (0..2): `layers` shells per coil, shells of the three coils interleaved from the inside out, so
// that shell 3 n + index is the coil's n-th. Turns are evenly spaced over the band |height| <= band_half_width_m; those
// that do not divide by the layers lie one each on the outermost.
std::vector<Turn> MakeWinding(const base::CoilGeometry& coil, int index);

// Odd orders l = 1, 3, ..., 2 kCoilOrders - 1 of zonal.h.
inline constexpr int kCoilOrders = 7;
using CoilMoments = std::array<double, kCoilOrders>;

// Moments per ampere of the bare winding, seen from beyond its outermost turn. docs/theory/magnetics.md (13)
CoilMoments WindingMoments(const std::vector<Turn>& winding);

// Moments per ampere that the winding induces in the core. docs/theory/magnetics.md (14), (15)
CoilMoments CoreMoments(const std::vector<Turn>& winding, double core_radius_m, double kappa);

// Field per ampere at x (B frame), winding turn by turn plus the core: exact but for the core's orders above
// 2 kCoilOrders - 1 (below 1e-9 at the sensors).
Eigen::Vector3d CoilField(const std::vector<Turn>& winding, const CoilMoments& core, const Eigen::Vector3d& axis,
                          const Eigen::Vector3d& x);

}  // namespace omni::magnetics
