// Checks that contacts give the hand no energy: the last safety net under the rule of stability.h, for hands and delays
// that are not as assumed. docs/theory/haptics.md, section 3.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// One tick of all contacts as this watch and that of swing_watch.h see it.
struct ContactTick {
  Vec3 tip;  // as measured, not predicted, base frame, m
  double dt_s = 0;
  double noise_m = 0;        // standard deviation of the tip
  Vec3 force_N;              // of what is touched, before any gain
  double stiffness_N_m = 0;  // of the stiffest spring that acts; 0: nothing is touched
  double stored_J = 0;       // in the springs of all contacts now
  double lag_s = 0;      // (3.1): force and motion belong to the same instant, the force was sent this long before the
                         // tip moved; not a number: no energy is counted
  bool judged = false;   // for swings: nothing else moves the hand, or what it touches
  bool passive = false;  // for energy: nothing but contacts with surfaces at rest acts, at their full force
};

// Gain in [0.1, 1] on the contact forces of this tick.
double WatchEnergy(const ContactTick& tick, EnergyState& state) noexcept;

// The force that left the renderer in this tick. Call once per tick, after WatchEnergy.
void RememberForce(const Vec3& force_N, EnergyState& state) noexcept;

}  // namespace omni::haptics
