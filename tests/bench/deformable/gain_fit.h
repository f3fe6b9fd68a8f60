// Source of the constants of service/haptics/deformable/local_model.h: least squares against a neo-Hookean half-space.
#pragma once

#include <array>

#include "tests/bench/deformable/axisymmetric.h"

namespace omni::bench {

struct GainFit {
  std::array<double, 3> linear{};     // g1 = l0 + l1 nu + l2 nu^2
  std::array<double, 3> quadratic{};  // g2
  double worst = 0;                   // |residual| of F / F_Hertz
  int points = 0;
  bool converged = true;
};

// Half-space: 300 balls deep and wide. Depths 0.05 ... 0.55 balls, nu 0 ... 0.45.
GainFit FitGain(const AxisMesh& mesh);

}  // namespace omni::bench
