// A scene that stands somewhere else, and moves as one body: rendered in its own frame, as if the pen moved the other
// way. docs/theory/haptics.md, section 15.
#pragma once

#include "service/haptics/haptics.h"
#include "service/haptics/state.h"

namespace omni::haptics {

inline constexpr double kFurthestBase_m = 100;

// Step with the scene at `placement`. `input` and `output` are in the base frame but for `input.poses`, which are in
// the scene's. `leaps`: it was teleported there since the last tick, not moved: forces at the old place fade out, those
// at the new one fade in. An invalid placement (not finite, not unit, too far) leaves the scene where it was. At the
// origin, and since then, this is Step, bit by bit.
void StepPlaced(const Config& config, const Scene& scene, const Placement& placement, bool leaps, const Input& input,
                State& state, Output& output) noexcept;

}  // namespace omni::haptics
