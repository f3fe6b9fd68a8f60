#include "service/tracker/filter/filter.h"

#include "service/tracker/filter/axis_filter.h"
#include "service/tracker/filter/position_filter.h"

namespace omni::tracker {

void ResetFilter(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept {
  state = FilterState{};
  ResetMotion(noise, measured, state);
  ResetTurning(noise, measured, state);
}

void PredictFilter(const FilterNoise& noise, double dt_s, bool pushed, FilterState& state) noexcept {
  const TransitionRates& follows_1_s = pushed ? noise.follows_pushed_1_s : noise.follows_1_s;
  PredictMotion(noise, follows_1_s, dt_s, state);
  PredictTurning(noise, follows_1_s, dt_s, state);
}

void CorrectFilter(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                   FilterState& state) noexcept {
  if (!CorrectMotion(noise, measured, dt_s, state)) return ResetFilter(noise, measured, state);
  CorrectTurning(noise, measured, dt_s, state);
}

}  // namespace omni::tracker
