// Watches that contacts give the hand no energy: the last net under the rule of stability.h, for hands and delays that
// are not as assumed. docs/theory/haptics.md, section 3.
#pragma once

#include "service/haptics/geometry/vec_math.h"
#include "service/haptics/state.h"

namespace omni::haptics {

// One tick as the watch sees it. Force and motion belong to the same instant: the force is the one that was sent
// `lag_s` before the tip moved.
struct WatchedTick {
  Vec3 tip;  // as measured, not predicted, base frame, m
  double dt_s = 0;
  double lag_s = 0;      // (3.1); not a number: nothing is counted
  double stored_J = 0;   // in the springs of all contacts now
  bool passive = false;  // nothing but contacts with surfaces at rest acts, at their full force; else no leak is seen
};

// Gain in [0.1, 1] on the contact forces of this tick.
double WatchEnergy(const WatchedTick& tick, EnergyState& state) noexcept;

// What left the renderer in this tick. Call once a tick, after WatchEnergy.
void RememberForce(const Vec3& force_N, EnergyState& state) noexcept;

}  // namespace omni::haptics
