// The position part of the filter. docs/theory/tracking.md (7.1), (7.2)
#pragma once

#include <Eigen/Core>
#include <optional>

#include "service/tracker/filter/filter.h"

namespace omni::tracker {

void ResetMotion(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept;
void PredictMotion(const FilterNoise& noise, const TransitionRates& follows_1_s, double dt_s,
                   FilterState& state) noexcept;
// False: the measured position cannot follow from the prediction.
bool CorrectMotion(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s, FilterState& state) noexcept;

// A filter whose q is right has white innovations [Mehra 1970]: `whitened` . `recent` is zero on the average; positive
// means that the filter lags behind.
void LearnLiveliness(const FilterNoise& noise, const Eigen::Vector3d& whitened, Liveliness& liveliness) noexcept;

// Of the last four measurements; none before there are four.
std::optional<Eigen::Vector3d> ThirdDifference(const base::Vec3& measured, Whiteness& whiteness) noexcept;

// third_squared: of differences whose claimed variances add up to `variance`.
void LearnShare(const FilterNoise& noise, double third_squared, double variance, double dt_s, double& share) noexcept;

}  // namespace omni::tracker
