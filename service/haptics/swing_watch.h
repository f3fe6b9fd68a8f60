// Watches that what is touched does not make the hand swing, as it does when the loop is later or the hand lighter than
// the rule of stability.h assumes. It trusts nothing but the measured tip. docs/theory/haptics.md (3.10)
#pragma once

#include "service/base/vec.h"
#include "service/haptics/energy_watch.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// Gain in [0.01, 1] on the forces of this tick.
double WatchSwings(const ContactTick& tick, SwingState& state) noexcept;

// Of this watch and of that over the energy, which sees what this one leaves of the springs.
double WatchContacts(const ContactTick& tick, SwingState& swing, EnergyState& energy) noexcept;

}  // namespace omni::haptics
