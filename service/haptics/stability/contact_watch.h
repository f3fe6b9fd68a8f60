// Checks that contacts give the hand no energy, and that they do not make it swing: the last safety net under the rule
// of stability.h, for hands and delays that are not as assumed. Swings are found in the measured tip alone.
// docs/theory/haptics.md, section 3.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// Of the hand's damping that a surface may take: by the rule of stability.h half of b = 1 Ns/m   (3.2)
inline constexpr double kMayTake_Ns_m = 0.5;

// One tick of all contacts as the watches see it.
struct ContactTick {
  Vec3 tip;           // as measured, not predicted, base frame, m
  Vec3 velocity_m_s;  // of it
  double dt_s = 0;
  double noise_m = 0, velocity_noise_m_s = 0;  // standard deviations of both
  Vec3 force_N;                                // of what is touched, before any gain
  double stiffness_N_m = 0;                    // of the stiffest spring that acts; 0: nothing is touched
  double stored_J = 0;                         // in the springs of all contacts now
  ActingForce acting;                          // on the pen when the tip was measured
  bool judged = false;                         // for swings: nothing else moves the hand, or what it touches
  bool passive = false;  // for energy: nothing but contacts with surfaces at rest acts, at their full force
};

// Gain in [0.1, 1] on the contact forces of this tick.
double WatchEnergy(const ContactTick& tick, EnergyState& state) noexcept;

// Gain in [0.01, 1] on the forces of this tick, which are also reduced by other_gain.
double WatchSwings(const ContactTick& tick, double other_gain, SwingState& state) noexcept;

// Of both, where the energy watch sees the springs as the other has reduced them.
double WatchContacts(const ContactTick& tick, SwingState& swing, EnergyState& energy) noexcept;

}  // namespace omni::haptics
