// How one scan is explained: the pose near where it was expected, one anywhere, and what else may be wrong if neither
// fits. docs/theory/tracking.md
#pragma once

#include "service/tracker/solve/scan_context.h"

namespace omni::tracker {

// Starts at the predicted pose; the filter's rates take each sensor back to its own instant.
Outcome TryWarm(const Config& config, const FilterState& predicted, KernelSums* sums,
                Measurement& measurement) noexcept;

// Leaves out a sensor that repeats the same reading before it becomes wrong.
void BlameFrozen(const Config& config, const base::HallScan& scan, State& state) noexcept;

// The scan fits much worse than the ones before: has the ambient field jumped? True: `state` holds that now,
// `measurement` and `outcome` are of it.
bool TryJump(const ScanContext& context, const FilterState& predicted, State& state, Measurement& measurement,
             Outcome& outcome) noexcept;

// The scan did not fit where the pen was expected. In turn: the ambient field has jumped; one sensor is wrong (a few
// per scan); the calibration is worse than stated. True: `state` holds that now, `measurement` and `outcome` are of it.
bool TryOtherHypotheses(const ScanContext& context, const FilterState& predicted, State& state,
                        Measurement& measurement, Outcome& outcome) noexcept;

// Cold start, each time under another assumption; one that fits is adopted, and `measurement` belongs to it.
Outcome TryColdHypothesis(const ScanContext& context, State& state, Measurement& measurement) noexcept;

// The same while no pose explains any scan: the next step of the search for another magnet present from the start.
// Precondition: TryColdHypothesis found no pose.
Outcome TryPair(const ScanContext& context, State& state, Measurement& measurement) noexcept;

// After a scan that fitted: checks for a wrong sensor, one left out that is right again, or a worse calibration.
void DoubtOn(const ScanContext& context, const FilterState& predicted, const Measurement& measurement,
             const Outcome& outcome, State& state) noexcept;

}  // namespace omni::tracker
