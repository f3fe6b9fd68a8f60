#include "service/haptics/contact/softness.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::haptics {

// Sphere R on a Winkler layer of thickness h: F = pi R E_c delta^2 / h, E_c = E (1 - nu) / ((1 + nu)(1 - 2 nu))
// [Johnson, Contact Mechanics, 4.3]. In series with K: K (d - delta) = c delta^2, so
// delta = 2 K d / (K + sqrt(K^2 + 4 c K d)), at most max_depth; then only the spring K is left.   (4.1), (4.2)
double ElasticForce(const Softness& softness, double stiffness_N_m, double depth_m) noexcept {
  if (!(depth_m > 0 && stiffness_N_m > 0)) return 0;
  if (softness.model == SoftnessModel::kNone) return stiffness_N_m * depth_m;
  const double nu = std::clamp(softness.poisson_ratio, 0.0, 0.49);
  const double confined_Pa = softness.young_modulus_Pa * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  const double c = std::numbers::pi * kIndenterRadius_m * confined_Pa / std::max(softness.thickness_m, 1e-6);
  const double k = stiffness_N_m;
  const double delta = 2 * k * depth_m / (k + std::sqrt(k * k + 4 * std::max(c, 0.0) * k * depth_m));
  return k * (depth_m - std::min(delta, std::max(softness.max_depth_m, 0.0)));
}

// Maxwell branch beside the layer: r' = g F' - r / tau, exactly integrated over a tick   (4.3). The series stiffness is
// lowered by 1 + g, so that the instantaneous slope stays within the stiffness bound.
double LayerForce(const Softness& softness, double stiffness_N_m, double depth_m, double dt_s,
                  ContactState& contact) noexcept {
  if (softness.model == SoftnessModel::kNone) return ElasticForce(softness, stiffness_N_m, depth_m);
  const double elastic_N = ElasticForce(softness, stiffness_N_m / (1 + kRelaxingShare), depth_m);
  const double keep = softness.relaxation_time_s > 0 ? std::exp(-dt_s / softness.relaxation_time_s) : 0;
  contact.relaxation_N = keep * (contact.relaxation_N + kRelaxingShare * (elastic_N - contact.elastic_N));
  contact.elastic_N = elastic_N;
  return std::max(0.0, elastic_N + contact.relaxation_N);
}

}  // namespace omni::haptics
