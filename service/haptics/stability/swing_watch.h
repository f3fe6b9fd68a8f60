// Checks that contacts do not make the hand swing, as they do when the loop is slower or the hand lighter than the rule
// of stability.h assumes. It relies on the measured tip alone. docs/theory/haptics.md (3.10)
#pragma once

#include "service/base/vec.h"
#include "service/haptics/stability/energy_watch.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// Gain in [0.01, 1] on the forces of this tick, which are also reduced by other_gain.
double WatchSwings(const ContactTick& tick, double other_gain, SwingState& state) noexcept;

// Of this watch and of the energy watch, which sees the springs as reduced by this one.
double WatchContacts(const ContactTick& tick, SwingState& swing, EnergyState& energy) noexcept;

}  // namespace omni::haptics
