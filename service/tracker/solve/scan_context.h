// One scan, how it is measured under an assumption, and when a fit explains it.
#pragma once

#include "service/base/hall_scan.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/tracker.h"

namespace omni::tracker {

// A correct first pose is known this well (trace); where its chi2 exceeds this per degree of freedom, any other ambient
// field saves less than kFieldSaves.
inline constexpr double kKnown_m2 = 225e-6, kOddly = 1.5, kFieldSaves = 22;

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

// False for hidden currents, which leave no evidence of a drift.
bool LearnsDrift(const Config& config) noexcept;

Measurement MeasureScan(const ScanContext& context, const DriftState& drift, const Doubt& doubt) noexcept;

// Usable readings less the unknowns without a prior: the scan's, the pose, and a poorly known ambient field.
int DegreesOfFreedom(const Measurement& measurement) noexcept;
bool HasMagnet(const Config& config, const Measurement& measurement) noexcept;

double PositionVariance(const Fit& fit) noexcept;  // trace, m^2
bool FitsReadings(const Config& config, const Measurement& measurement, const Fit& fit) noexcept;
bool IsInReach(const Config& config, const Pose& pose) noexcept;

Precision PrecisionOf(const Config& config) noexcept;
// From a start that may be far off.
Fit SolveCold(const Config& config, const Measurement& measurement, const Pose& start) noexcept;

}  // namespace omni::tracker
