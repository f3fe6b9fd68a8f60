// Which objects are touched: takes contacts on, follows them, lets them go. docs/theory/haptics.md, section 2.
#pragma once

#include "service/haptics/contact/proxy.h"

namespace omni::haptics {

// The tip has just appeared: objects it is inside of become contacts at the nearest point of their surface.
void StartContacts(const Scene& scene, const Surface& surface, const Vec3& tip, State& state) noexcept;

// The tip moved from state.last_device_point_base_m to `tip`: follows every contact, takes on what the motion entered.
void UpdateContacts(const Scene& scene, const Surface& surface, const Vec3& tip, double dt_s, State& state) noexcept;

inline constexpr double kTrustedDepth_m = 0.002;  // deeper, a proxy that faces the wrong way round an edge is let go
inline constexpr double kSwapFade_s = 0.02;

// A tip that was pushed through a part is let go when it is this far from its proxy, in the open, for this long.
inline constexpr double kThroughDepth_m = 0.010;
inline constexpr double kThroughTime_s = 0.1;

}  // namespace omni::haptics
