// The force map: F = X(pose) I + F_snap, T = Y(pose) I + T_snap. Coil fields as zonal multipoles (winding + core), the
// magnet as a few point dipoles. docs/theory/actuation.md; its error: `omni-bench force`.
#pragma once

#include <array>
#include <type_traits>

#include "service/actuation/force_kernel.h"
#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::actuation {

// The magnet as a few point dipoles: what a field that varies over the magnet acts upon. Set-up only.

// A share of the moment at ring_1 e1 + ring_2 e2 + axial u from the centre.
struct WeightedPoint {
  double ring_1_m = 0, ring_2_m = 0, axial_m = 0;
  double share = 0;  // of the moment; 0: unused
};
using WeightedPoints = std::array<WeightedPoint, kForcePoints>;

// As many terms of the magnet's own multipoles as the points keep: q1 | q1, q3 | q1, q3, q5.
enum class MagnetDetail : unsigned char { kPoint, kRing, kFull };

// Points with the moments q3 = m k3 and q5 = m k5 of the magnet (docs/theory/magnetics.md (8)), so that in any field
// that has no source inside the magnet force and torque are right up to the sixth derivative of its potential.
// docs/theory/actuation.md (2.6)
WeightedPoints MakeMagnetPoints(const base::MagnetGeometry& magnet, MagnetDetail detail);

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

// How much force may be requested of a base of limited accuracy. Set-up only. docs/theory/actuation.md (7.1)

// Poses of an uncalibrated base are almost never further off: tests/loop/uncalibrated.cc.
inline constexpr double kDrawnError_m = 12e-3;

// The share of the greatest force, 0 to 1, that keeps the true force within it although the pen may touch the hull
// while it seems to be `position_error_m` away from it: force per ampere there over that at the hull.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device, double position_error_m) noexcept;

// For the nominal base, and for a calibrated one: with three times the error that the calibration states. One that
// states none counts as nominal.
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device) noexcept;
double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device,
                  const base::Calibration& calibration) noexcept;

}  // namespace omni::actuation
