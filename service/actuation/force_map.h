// The force map: F = X(pose) I + F_snap, T = Y(pose) I + T_snap. Coil fields as zonal multipoles (winding + core), the
// magnet as a few point dipoles. docs/theory/actuation.md; its error: `omni-bench force`.
#pragma once

#include <array>
#include <type_traits>

#include "service/actuation/force_kernel.h"
#include "service/actuation/magnet_points.h"
#include "service/base/calibration.h"
#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::actuation {

// Prepared once.
struct ForceMap {
  ForceTables tables;
  double winding_radius_m = 0;   // the map is valid where every magnet point is further from the origin than this
  ForceKernel kernel = nullptr;  // null: no map
};
static_assert(std::is_trivially_copyable_v<ForceMap>);

// Poorer models, for comparison.
struct ForceModel {
  int orders = kForceOrders;  // 1: coils are dipoles, 4: l <= 7
  MagnetDetail magnet = MagnetDetail::kFull;
  double scale = 1;  // of X
};

// Nominal geometry.
ForceMap MakeForceMap(const base::DeviceGeometry& device, const ForceModel& model = {});
// Moment and size of the magnet, and the core, as calibrated.
ForceMap MakeForceMap(const base::DeviceGeometry& device, const base::Calibration& calibration,
                      const ForceModel& model = {});

struct ForceAtPose {
  bool valid = false;                               // false: inside the windings or not finite, all zero
  std::array<double, 9> newton_per_ampere{};        // X, row-major 3x3
  std::array<double, 9> newton_metre_per_ampere{};  // Y, about the magnet's centre
  base::Vec3 snapping_N, snapping_Nm;               // the core's pull at zero current
};
// moment_scale: of the pen in use, over the map's: coils act in proportion to it, the core's pull with its square.
ForceAtPose EvaluateForceMap(const ForceMap& map, const base::Vec3& position_base_m, const base::Vec3& axis_base,
                             double moment_scale = 1) noexcept;

}  // namespace omni::actuation
