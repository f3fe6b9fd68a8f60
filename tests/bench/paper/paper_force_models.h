// Three models of the force on the magnet: the paper's dipole law, the twin, our force map. All for a magnet whose axis
// points at the base's centre.
#pragma once

#include "service/base/device_geometry.h"

namespace omni::bench {

// N/A of each coil on a magnet on that coil's own axis (radial) and of coils x and y on a magnet on top (tangential);
// the core's pull at zero current, N.
struct ForceTable {
  double radial_x_N_A = 0, radial_y_N_A = 0, radial_z_N_A = 0;
  double tangential_x_N_A = 0, tangential_y_N_A = 0;
  double snapping_N = 0;
};

// Magnet `distance_m` from the core's centre, core as strong as `kappa` says.
ForceTable TwinForces(const base::DeviceGeometry& device, double distance_m, double kappa);
ForceTable OurForces(const base::DeviceGeometry& device, double distance_m, double kappa);

// Eq. 6-8 with the errata of docs/theory/actuation.md: F = 3 mu0 m m_e / (4 pi d^4) times 2 (radial) or 1 (tangential),
// m_e = C I as the tracker's calibration sees it. The law has no pull of the core: 0.
ForceTable PaperLawForces(const base::DeviceGeometry& device, double distance_m);

}  // namespace omni::bench
