// The response of a steel plane under the base to the pen's field. docs/theory/tracking.md (12.1)
#pragma once

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/solve/solver.h"

namespace omni::tracker {

inline bool HasSteel(const Model& model) noexcept { return model.steel.strength != 0; }

// Whether the response is more than kSteelShare of the pen's own field at the sensors, where it is the most of a pen in
// use: far from the core. Less is lost in the model's error, of which it is half, and would still cost its computation
// in every tick. A real plane of strength 1 has ten times that at -400 mm.
inline constexpr double kSteelShare = 1e-3;
bool SteelMatters(const Model& model) noexcept;

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
