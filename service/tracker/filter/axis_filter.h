// The axis part of the filter. docs/theory/tracking.md (7.1), (7.2)
#pragma once

#include "service/tracker/filter/filter.h"

namespace omni::tracker {

void ResetTurning(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept;
void PredictTurning(const FilterNoise& noise, const TransitionRates& follows_1_s, double dt_s,
                    FilterState& state) noexcept;
void CorrectTurning(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                    FilterState& state) noexcept;

}  // namespace omni::tracker
