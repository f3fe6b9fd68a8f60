// The core's moment in the field of the pen's magnet, told as currents: those of coils whose moments add up to it.
#pragma once

#include <Eigen/Core>

#include "service/base/calibration.h"

namespace omni::magnetics {

// K, A m^3: currents per CoreFieldShape, a^3 kappa m_tool P^-1 with the coils' moments per ampere in P's columns, each
// the dipole at the core's centre whose field is nearest to the coil's maps. Zero where there is no core or not three
// coils. `calibration`: places from the core's centre. docs/theory/calibration.md (1a)
Eigen::Matrix3d CoreCurrents(const base::Calibration& calibration);

//   (3 (u.n) n - u) / r^3,   n = p / r:   of the pen's field at the core's centre; zero at it
Eigen::Vector3d CoreFieldShape(const Eigen::Vector3d& p_m, const Eigen::Vector3d& u) noexcept;

}  // namespace omni::magnetics
