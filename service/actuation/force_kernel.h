// The arithmetic of the force map: plain numbers in, plain numbers out. One variant per instruction set, each in a file
// of its own that includes nothing but this header and service/base/lanes.h, so that no inline function of a library is
// compiled twice.
// All variants give the same bits: no contraction, sums over the points in a fixed order.
#pragma once

namespace omni::actuation {

inline constexpr int kForceOrders = 7;  // odd orders 1, 3, ..., 13 of each coil
inline constexpr int kForcePoints = 8;  // lanes: two AVX2 vectors
inline constexpr int kForceCoils = 3;

// Prepared once. Points with moment 0 are unused.
struct ForceTables {
  double ring_1_m[kForcePoints] = {};  // offset along e1, e2, u
  double ring_2_m[kForcePoints] = {};
  double axial_m[kForcePoints] = {};
  double moment_Am2[kForcePoints] = {};
  double zonal[kForceCoils][kForceOrders] = {};  // A m^(l+1) per ampere, core included
  double axis_base[kForceCoils][3] = {};
  double core_radius_m = 0;
  double core_kappa = 0;
};

// The magnet: centre, and its frame as three unit vectors.
struct ForcePose {
  double position_m[3];
  double e1[3], e2[3], u[3];
};

struct ForceSums {
  double square_radius_m2[kForcePoints];  // of every point from the core's centre
  double force_N_A[kForceCoils][3];       // per coil
  double torque_Nm_A[kForceCoils][3];     // about the centre of the magnet
  double snapping_N[3];
  double snapping_Nm[3];
};

using ForceKernel = void (*)(const ForceTables& tables, const ForcePose& pose, ForceSums& sums) noexcept;

void ForceKernelBaseline(const ForceTables& tables, const ForcePose& pose, ForceSums& sums) noexcept;
void ForceKernelAvx2(const ForceTables& tables, const ForcePose& pose, ForceSums& sums) noexcept;

enum class ForceKernelLevel : unsigned char { kBaseline, kAvx2 };
inline constexpr int kForceKernelLevels = 2;

// Null when this processor cannot run it.
ForceKernel ForceKernelOf(ForceKernelLevel level) noexcept;
// The widest that runs here.
ForceKernel BestForceKernel() noexcept;

}  // namespace omni::actuation
