// How one scan is explained: the pose near where it was expected, one anywhere, and what else may be wrong if neither
// fits. docs/theory/tracking.md
#pragma once

#include "service/base/hall_scan.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

struct Outcome {
  bool good = false;       // fits, in reach
  bool explained = false;  // some pose fits, in reach or not
  bool cold = false;
  Fit fit;
};

// One scan, and the currents before it and now.
struct ScanContext {
  const Config& config;
  const base::HallScan& scan;
  const CurrentHistory& before;
  const CurrentHistory& now;
  const LocalField* local = nullptr;  // known at each sensor; null: none
  const StrayField* stray = nullptr;  // null: none
  AmbientChange mains = {};
};

// Hidden currents leave nothing to tell a drift by.
bool LearnsDrift(const Config& config) noexcept;

Measurement MeasureScan(const ScanContext& context, const DriftState& drift, const Doubt& doubt) noexcept;

// Unknowns of the scan without a prior, the pose's included, and those of an ambient field that is hardly known.
int DegreesOfFreedom(const Measurement& measurement) noexcept;
bool HasMagnet(const Config& config, const Measurement& measurement) noexcept;

// Starts at the predicted pose; the filter's rates take each sensor back to its own instant.
Outcome TryWarm(const Config& config, const FilterState& predicted, KernelSums* sums,
                Measurement& measurement) noexcept;

// A sensor that says the same again and again is left out before it is wrong.
void BlameFrozen(const Config& config, const base::HallScan& scan, State& state) noexcept;

// The scan fits much worse than the ones before: has the ambient field jumped? True: `state` holds that now,
// `measurement` and `outcome` are of it.
bool TryJump(const ScanContext& context, const FilterState& predicted, State& state, Measurement& measurement,
             Outcome& outcome) noexcept;

// The scan did not fit where the pen was expected. In turn: the ambient field has jumped; one sensor is wrong (a few a
// scan); the calibration is worse than it says. True: `state` holds that now, `measurement` and `outcome` are of it.
bool TryOtherBeliefs(const ScanContext& context, const FilterState& predicted, State& state, Measurement& measurement,
                     Outcome& outcome) noexcept;

// Without a hint of where the pen is, each time with another belief; one that fits is taken over, `measurement` is of
// it.
Outcome TryColdBelief(const ScanContext& context, State& state, Measurement& measurement) noexcept;

// The same while no pose explains any scan: the next step of looking for another magnet that has been there from the
// start. Precondition: TryColdBelief found no pose.
Outcome TryPair(const ScanContext& context, State& state, Measurement& measurement) noexcept;

// After a scan that fitted: is a sensor wrong, or one that was left out right again, or the calibration worse?
void DoubtOn(const ScanContext& context, const FilterState& predicted, const Measurement& measurement,
             const Outcome& outcome, State& state) noexcept;

}  // namespace omni::tracker
