// Laps that cannot be cheated, timed to a fraction of a tick. docs/theory/haptics.md, section 8.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// The car went straight from `before` to `after` in dt_s. A lap is: over the start line in its direction, then every
// checkpoint in its direction and order, then over the start line again. A checkpoint or start line crossed backwards
// is undone, so that turning round gains nothing.
void AdvanceLap(const VehicleInput& car, const Vec3& before, const Vec3& after, double dt_s, LapState& lap) noexcept;

}  // namespace omni::haptics
