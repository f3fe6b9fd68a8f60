// A coil of the base: a band of circular turns on spherical shells around the iron core; the field of a turn in closed
// form; and the core's moment in a field. Set-up only: allocates.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "service/base/device_geometry.h"

namespace omni::magnetics {

// Complete elliptic integrals of parameter m = k^2 in [0, 1), by the arithmetic-geometric mean.
struct EllipticIntegrals {
  double K = 0;
  double E = 0;
};
EllipticIntegrals CompleteElliptic(double m) noexcept;

// Field (T/A) of a loop of radius `radius_m` about +z, centred at the origin, at cylindrical (rho, z); positive current
// gives a moment along +z. Relative error below 1e-8 everywhere but on the wire itself. docs/theory/magnetics.md (12)
struct LoopField {
  double rho_T_A = 0;
  double z_T_A = 0;
};
LoopField FieldOfLoop(double radius_m, double rho_m, double z_m) noexcept;

// The same as a vector: loop of radius `radius_m` centred at height_m * axis, normal to `axis` (unit), observed at x.
Eigen::Vector3d FieldOfLoop(double radius_m, double height_m, const Eigen::Vector3d& axis,
                            const Eigen::Vector3d& x) noexcept;

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

// The core's moment in a field, expressed as currents: those of coils whose moments add up to it.
// K, A/T: currents per field at the core's centre, (a^3 kappa 4 pi / mu0) P^-1 with the coils' moments per ampere in
// P's columns, each the dipole at that centre whose field is nearest to the coil's maps. Zero where there is no core or
// not three coils. `calibration`: places from the core's centre. docs/theory/calibration.md (1.2)
Eigen::Matrix3d CoreCurrents(const base::Calibration& calibration);

}  // namespace omni::magnetics
