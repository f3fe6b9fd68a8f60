// Materials that the application changes while they are in use. docs/theory/haptics.md, section 15.
#pragma once

#include "service/haptics/haptics.h"
#include "service/haptics/state.h"

namespace omni::haptics {

inline constexpr double kMaterialGlide_s = 0.030;  // time constant of a change under a touching pen

// Takes `input.materials` into `state`: at once while nothing is touched, else gliding, so that the force is
// continuous. A material that is no longer named reverts to the scene's. True: one of them is still changing.
bool ChangeMaterials(const Scene& scene, const Input& input, bool touching, State& state) noexcept;

}  // namespace omni::haptics
