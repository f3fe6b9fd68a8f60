// The magnet as a few point dipoles: what a field that varies over the magnet acts upon. Set-up only.
#pragma once

#include <array>

#include "service/actuation/force_kernel.h"
#include "service/base/device_geometry.h"

namespace omni::actuation {

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

}  // namespace omni::actuation
