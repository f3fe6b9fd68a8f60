// Soft surface: an elastic layer in series with the contact's stiffness, with one relaxing term.
// docs/theory/haptics.md, section 4.
#pragma once

#include "service/haptics/state.h"

namespace omni::haptics {

inline constexpr double kIndenterRadius_m = 0.003;  // of the pen's tip
inline constexpr double kRelaxingShare = 0.3;       // instantaneous over long-term modulus, minus one

// Normal force of the whole contact at `depth_m`, without damping. Monotone in depth, slope at most `stiffness_N_m`.
// `softness.model` kNone: stiffness * depth. kTet, before its body is ready: as kWinkler.
double ElasticForce(const Softness& softness, double stiffness_N_m, double depth_m) noexcept;

// Adds the relaxing part; updates contact.elastic_N and contact.relaxation_N.
double LayerForce(const Softness& softness, double stiffness_N_m, double depth_m, double dt_s,
                  ContactState& contact) noexcept;

}  // namespace omni::haptics
