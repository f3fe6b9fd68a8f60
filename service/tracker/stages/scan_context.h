// One scan, how it is measured and fitted under an assumption, and when a fit explains it.
#pragma once

#include "service/base/eigen.h"
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

// Drift and doubts are learnt from currents that are measured.
inline bool CanDoubt(const Config& config, const RoomState& room) noexcept {
  return LearnsDrift(config) && room.drift.valid;
}

inline Pose PoseOf(const FilterState& filter) noexcept {
  return {base::ToEigen(filter.position_base_m), base::ToEigen(filter.axis_base)};
}

Measurement MeasureScan(const ScanContext& context, const DriftState& drift, const Doubt& doubt) noexcept;

// Usable readings less the unknowns without a prior: the scan's, the pose, and a poorly known ambient field.
int DegreesOfFreedom(const Measurement& measurement) noexcept;
bool HasMagnet(const Config& config, const Measurement& measurement) noexcept;

double PositionVariance(const Fit& fit) noexcept;  // trace, m^2
bool FitsReadings(const Config& config, const Measurement& measurement, const Fit& fit) noexcept;
bool IsInReach(const Config& config, const Pose& pose) noexcept;

Precision PrecisionOf(const Config& config) noexcept;
// From the predicted pose; the filter's rates take each sensor back to its own instant. sums: SolveOptions::sums.
Outcome FitWarm(const Config& config, const FilterState& predicted, KernelSums* sums,
                Measurement& measurement) noexcept;

// From the best grid points in turn. A fit that passes the gate out of reach ends the search: the pen is elsewhere.
// The steel's response is known once there is a pose: then each is fitted again, and `measurement` belongs to it.
Outcome FitCold(const ScanContext& context, const DriftState& drift, const Doubt& doubt,
                Measurement& measurement) noexcept;

// Chi2 of a warm fit under another assumption, or `no_fit`.
double Chi2Under(const ScanContext& context, const FilterState& predicted, const DriftState& drift, const Doubt& doubt,
                 double no_fit) noexcept;
inline double Chi2Of(const Outcome& outcome, double no_fit) noexcept {
  return outcome.fit.converged ? outcome.fit.chi2 : no_fit;
}
inline constexpr double kNoFitChi2 = 1e6;

// Leaves out one more sensor in turn, and adds what that saves of `chi2`. failing: the scan does not fit.
void TrySensor(const ScanContext& context, const FilterState& predicted, const DriftState& drift, bool failing,
               double chi2, Doubt& doubt) noexcept;

// From a start that may be far off.
Fit SolveCold(const Config& config, const Measurement& measurement, const Pose& start) noexcept;

}  // namespace omni::tracker
