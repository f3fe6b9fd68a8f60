// Watches that what is touched does not make the hand swing, as it does when the loop is later or the hand lighter than
// the rule of stability.h assumes. It trusts nothing but the measured tip. docs/theory/haptics.md (3.10)
#pragma once

#include "service/haptics/energy_watch.h"
#include "service/haptics/geometry/vec_math.h"
#include "service/haptics/state.h"

namespace omni::haptics {

// One tick as the watch sees it.
struct SwingTick {
  Vec3 tip;                  // as measured, not predicted, base frame, m
  Vec3 force_N;              // of what is touched, before any gain
  double stiffness_N_m = 0;  // of the stiffest spring that acts; 0: nothing is touched
  double noise_m = 0;        // standard deviation of the tip
  double dt_s = 0;
  bool judged = false;  // nothing else moves the hand, or what it touches
};

// Gain in [0.01, 1] on the forces of this tick.
double WatchSwings(const SwingTick& tick, SwingState& state) noexcept;

// Of this watch and of that over the energy, which sees what this one leaves of `whole`.
double WatchContacts(const SwingTick& tick, const WatchedTick& whole, SwingState& swing, EnergyState& energy) noexcept;

}  // namespace omni::haptics
