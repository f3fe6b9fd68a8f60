// Linear elasticity of one point of a body: the 6 x 6 stiffness, isotropic or stiffer along a fibre, and how hard it is
// to indent. Voigt order xx, yy, zz, yz, zx, xy with engineering shears. docs/theory/deformable.md, section 2. Set-up
// only.
#pragma once

#include <array>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

using Stiffness6 = std::array<std::array<double, 6>, 6>;  // Pa, symmetric

struct ElasticModuli {
  double young_modulus_Pa = 2e5;  // across the fibre; [1e2, 1e9]
  double poisson_ratio = 0.4;     // [0, 0.49]
  double fibre_ratio = 1;         // modulus along the fibre over that across; [1, 100]; 1: isotropic
};

base::Status CheckModuli(const ElasticModuli& moduli);

// Precondition: CheckModuli(moduli).ok(). `fibre`: any length; zero counts as z.   (2.1), (2.2)
Stiffness6 MakeStiffness(const ElasticModuli& moduli, const Vec3& fibre);

// Modulus M of a half-space with unit normal n: a small ball presses in by d = (3 F / (4 M sqrt R))^(2/3). Isotropic:
// E / (1 - nu^2). Exact for the mean over directions in the surface; the contact is taken to stay round
// [Vlassak & Nix 1994; Barnett & Lothe 1973].   (2.3)
double IndentationModulus(const Stiffness6& stiffness, const Vec3& normal);

}  // namespace omni::haptics
