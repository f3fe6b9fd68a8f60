// The pulse that renders a detent click: when the force passes its threshold the surface yields for a moment, and it
// returns when the force has fallen. Half a sine along the contact's normal, added to the contact force under its
// limits.
#pragma once

#include <type_traits>

#include "service/base/input_mapping.h"
#include "service/base/vec.h"
#include "service/loop/inputs.h"

namespace omni::loop {

inline constexpr double kDetentPulse_s = 0.012;  // 42 Hz: the coils follow it
inline constexpr double kDetentReturn = 0.5;     // of the pulse, when it comes back

struct DetentState {
  bool on = false;
  double time_s = kDetentPulse_s;  // of the pulse that is running
  double amplitude_N = 0;
  base::Vec3 normal_base;  // of the contact that was pressed
};
static_assert(std::is_trivially_copyable_v<DetentState>);

// Force of this tick. Zero while no component is mapped to the detent.
base::Vec3 DetentForce_N(const base::InputMapping& mapping, const InputTracker& tracker, const haptics::Output& haptics,
                         double dt_s, DetentState& state) noexcept;

}  // namespace omni::loop
