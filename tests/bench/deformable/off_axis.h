// The second reference: the ball off the axis, pressed in along the surface's normal. Neo-Hookean like the first one
// (axisymmetric.h), but in three dimensions: quadratic elements in depth and distance from the ball's middle, Fourier
// series around it, mirrored at the plane through axis and ball. No code or mesh in common with the first reference or
// with the methods under test; on the axis the two must agree.
#pragma once

#include <vector>

#include "tests/bench/deformable/axisymmetric.h"

namespace omni::bench {

struct SolidMesh {
  double finest_m = 2.5e-4;  // element edge under the ball
  double growth = 1.6;       // of edges away from it
  int modes = 2;             // highest Fourier order around the ball's middle
};

// Force along the normal over E, one per depth; `aside_m`: distance of the ball's middle from the axis, at least a ball
// from the rim. Contact by a penalty 4e3 E / R; Newton with backtracking on the energy. `depths_m` ascending.
AxisCurve PressBallAside(const AxisBody& body, double aside_m, double poisson_ratio, double ball_radius_m,
                         const std::vector<double>& depths_m, const SolidMesh& mesh);

}  // namespace omni::bench
