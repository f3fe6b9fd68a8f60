// The response of a steel plane under the base to the pen's field. docs/theory/tracking.md (21)
#pragma once

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/solve/solver.h"

namespace omni::tracker {

inline bool HasSteel(const Model& model) noexcept { return model.steel.strength != 0; }

// At each sensor, and how it changes with the pose: position, turn about the tangents of its axis.
struct SteelResponse {
  LocalField field_T{};
  std::array<LocalField, kParameters> derivative{};
};

// `moment_scale`: of the model's moment. Precondition: HasSteel.
SteelResponse SteelResponseOf(const Model& model, const Pose& pose, double moment_scale) noexcept;

// Corrects a fit whose readings had the response at the pose `expected` subtracted: to the pose and covariance with the
// response at the fitted pose.
void CorrectForSteel(const Model& model, const Measurement& measurement, const Pose& expected,
                     const SteelResponse& answer, Fit& fit) noexcept;

}  // namespace omni::tracker
