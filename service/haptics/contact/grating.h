// A haptic texture as a grating that stays where it is: a ripple of the normal force whose phase belongs to the place
// that the tip slides over. docs/theory/haptics.md, section 6.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// The tip on a surface in this tick, in the object's rest frame.
struct SlidingTip {
  Vec3 place_m;        // on the surface
  Vec3 slip_m_s;       // along the surface, relative to it
  double ahead_s = 0;  // from `place_m` to the current that responds to it
  double coil_lag_s = 0;
  double dt_s = 0;
};

struct Grating {
  double amplitude_m = 0, wavelength_m = 0, gain = 0;

  bool IsFelt() const noexcept { return amplitude_m > 0 && gain > 0 && wavelength_m > 0; }

  // Force along the normal. Moves `state` on by a tick.
  double ForceOn(const SlidingTip& tip, double stiffness_N_m, double normal_force_N,
                 GratingState& state) const noexcept;
};

}  // namespace omni::haptics
