// What an application changes in a scene while it is in use: where it stands, and its materials.
// docs/theory/haptics.md, section 15.
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

inline constexpr double kMaterialGlide_s = 0.030;  // time constant of a change under a touching pen

// Takes `input.materials` into `state`: at once while nothing is touched, else gliding, so that the force is
// continuous. A material that is no longer named reverts to the scene's. True: one of them is still changing.
bool ChangeMaterials(const Scene& scene, const Input& input, bool touching, State& state) noexcept;

}  // namespace omni::haptics
