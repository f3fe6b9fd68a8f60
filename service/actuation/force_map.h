// The force map: F = X(pose) I + F_snap. Coil fields as zonal multipoles (winding + core), the magnet as a few point
// dipoles. Within 2 % of the exact force at contact and 0.6 % at 10 mm. docs/theory/actuation.md
#pragma once

#include <array>
#include <type_traits>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::actuation {

inline constexpr int kForceOrders = 7;  // odd orders 1, 3, ..., 13 of each coil
inline constexpr int kForcePoints = 5;  // magnetics::kMagnetPoints

struct ForcePoint {
  double ring_1_m = 0, ring_2_m = 0, axial_m = 0;  // offset along e1, e2, u
  double moment_Am2 = 0;
};

// Prepared once from DeviceGeometry.
struct ForceMap {
  std::array<base::Vec3, base::kCoilCount> axis_base{};
  std::array<std::array<double, kForceOrders>, base::kCoilCount> zonal{};  // A m^(l+1) per ampere, core included
  std::array<ForcePoint, kForcePoints> points{};
  double core_radius_m = 0;
  double core_kappa = 0;
  double winding_radius_m = 0;  // the map holds where every magnet point is farther from the origin than this
};
static_assert(std::is_trivially_copyable_v<ForceMap>);

ForceMap MakeForceMap(const base::DeviceGeometry& device);

struct ForceAtPose {
  bool valid = false;                         // false: inside the windings or not finite, all zero
  std::array<double, 9> newton_per_ampere{};  // X, row-major 3x3
  base::Vec3 snapping_N;                      // the core's pull at zero current
};
ForceAtPose EvaluateForceMap(const ForceMap& map, const base::Vec3& position_base_m,
                             const base::Vec3& axis_base) noexcept;

}  // namespace omni::actuation
