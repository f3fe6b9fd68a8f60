// The core's moment in a field, expressed as currents: those of coils whose moments add up to it.
#pragma once

#include <Eigen/Core>

#include "service/base/calibration.h"

namespace omni::magnetics {

// K, A/T: currents per field at the core's centre, (a^3 kappa 4 pi / mu0) P^-1 with the coils' moments per ampere in
// P's columns, each the dipole at that centre whose field is nearest to the coil's maps. Zero where there is no core or
// not three coils. `calibration`: places from the core's centre. docs/theory/calibration.md (1.2)
Eigen::Matrix3d CoreCurrents(const base::Calibration& calibration);

}  // namespace omni::magnetics
