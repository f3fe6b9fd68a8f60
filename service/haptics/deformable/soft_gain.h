// Gain of a large dent over Hertz's law, F / F_Hertz = 1 + g1 s + g2 s^2, s = sqrt(x / R), of a neo-Hookean half-space
// under a rigid frictionless ball. g1, g2 are quadratic in Poisson's ratio; the constants are the least-squares fit
// that `omni-bench deformable` repeats and prints beside them (side table "gain").   (5.1)
#pragma once

namespace omni::haptics {

struct SoftGain {
  double linear = 0, quadratic = 0;
};

inline constexpr double kGainLinear[3] = {0.2631, -0.3589, -0.4899};
inline constexpr double kGainQuadratic[3] = {-0.1795, -0.0029, 0.1863};

// nu in [0, 0.49]; `hardening` >= 0 is added to g2 (that is, per x / R).
constexpr SoftGain GainOf(double nu, double hardening) noexcept {
  return {kGainLinear[0] + nu * (kGainLinear[1] + nu * kGainLinear[2]),
          kGainQuadratic[0] + nu * (kGainQuadratic[1] + nu * kGainQuadratic[2]) + hardening};
}

}  // namespace omni::haptics
