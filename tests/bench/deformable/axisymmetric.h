// The reference of `omni-bench deformable`: a rigid frictionless ball pressed into a neo-Hookean body of revolution
// along its axis. Large strains, own mesh graded towards the contact, no code or mesh in common with the methods under
// test.
#pragma once

#include <string>
#include <vector>

namespace omni::bench {

// A cylinder on a clamped base. Its top is flat, or part of a sphere.
struct AxisBody {
  std::string name;
  double radius_m = 0.03;
  double height_m = 0.03;        // at the axis
  double cap_curvature_1_m = 0;  // of the top, convex > 0
  // Height of the top at distance r from the axis, and its derivative.
  double Top(double r_m) const;
  double TopSlope(double r_m) const;
};

struct AxisMesh {
  double finest_m = 1e-4;  // element edge at the contact
  double growth = 1.12;    // of edges away from it
};

struct AxisCurve {
  std::vector<double> force_per_modulus_m2;  // F / E, one per depth
  std::vector<double> top_r_m, top_fall_m;   // at the last depth: how far the top falls at a distance from the axis
  int nodes = 0;
  bool converged = true;
};

// W = mu/2 (I - 3) - mu ln J + lambda/2 (ln J)^2, bilinear elements, contact by a penalty 2e4 E / R on the surface;
// Newton with backtracking on the energy. `depths_m` ascending.
AxisCurve PressBall(const AxisBody& body, double poisson_ratio, double ball_radius_m,
                    const std::vector<double>& depths_m, const AxisMesh& mesh);

}  // namespace omni::bench
