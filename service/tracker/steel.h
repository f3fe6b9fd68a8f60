// What a steel plane under the base answers to the pen. docs/theory/tracking.md (21)
#pragma once

#include "service/tracker/measurement.h"
#include "service/tracker/solver.h"

namespace omni::tracker {

inline bool HasSteel(const Model& model) noexcept { return model.steel.strength != 0; }

// At each sensor; `moment_scale`: of the model's moment. Precondition: HasSteel.
LocalField SteelField(const Model& model, const Pose& pose, double moment_scale) noexcept;

}  // namespace omni::tracker
