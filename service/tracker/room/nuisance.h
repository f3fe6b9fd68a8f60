// What disturbs all sensors in a known shape but by an unknown amount: errors of the three currents (or the currents
// themselves; the core's remanence looks the same), and a uniform ambient field. docs/theory/tracking.md (3.2)
#pragma once

#include <array>

#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

// Fills the nuisance fields of `result`, whose weights are set. Variance 0: left out; infinite: no prior, the shape is
// projected out of what the usable axes see. Shapes that no usable axis sees cost nothing.
template <int kCapacity>
void SetNuisances(const Model& model, const std::array<double, base::kCoilCount>& current_variance_A2,
                  const std::array<double, 3>& ambient_variance_T2, BasicMeasurement<kCapacity>& result) noexcept;

extern template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&,
                                  const std::array<double, 3>&, Measurement&) noexcept;
extern template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&,
                                  const std::array<double, 3>&, ArrayMeasurement&) noexcept;

// To a scan whose unknowns are the three currents: the columns of an ambient field. Else nothing.
void AddAmbientColumns(Measurement& result) noexcept;

}  // namespace omni::tracker
