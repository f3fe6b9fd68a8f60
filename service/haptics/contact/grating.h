// A haptic texture as a grating that stays where it is: a ripple of the normal force whose phase belongs to the place
// that the tip slides over. docs/theory/haptics.md, section 6.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// Full below, and nothing above: neither coil nor tick follow.
inline constexpr double kRippleFade_Hz = 200, kRippleStop_Hz = 250;

// The tip on a surface in this tick, in the object's rest frame.
struct SlidingTip {
  Vec3 place_m;        // on the surface
  Vec3 slip_m_s;       // along the surface, relative to it
  double ahead_s = 0;  // from `place_m` to the current that responds to it
  double coil_lag_s = 0;
  double dt_s = 0;
};

// The place that the tip is known to be at, less noisy the slower it goes, in `state`. Once a tick.
void FollowPlace(const SlidingTip& tip, GratingState& state) noexcept;

// Where it will be when a force of this tick acts.
Vec3 PlaceOfForce(const SlidingTip& tip, const GratingState& state) noexcept;

struct Grating {
  double amplitude_m = 0, wavelength_m = 0, gain = 0;

  bool IsFelt() const noexcept { return amplitude_m > 0 && gain > 0 && wavelength_m > 0; }

  // Force along the normal. Moves `state` on by a tick (FollowPlace).
  double ForceOn(const SlidingTip& tip, double stiffness_N_m, double normal_force_N,
                 GratingState& state) const noexcept;
};

}  // namespace omni::haptics
