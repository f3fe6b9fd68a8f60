// A pen that lies still: what the model gets wrong there is the same in every scan, so that scans tell of changes only,
// and of these as exactly as their noise allows. docs/theory/tracking.md (32)
#pragma once

#include <array>
#include <type_traits>

#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

inline constexpr int kDriftStates = kNuisancesMax + 1;  // 3 currents, 3 ambient components, relative moment
using DriftVector = std::array<double, kDriftStates>;
using DriftMatrix = std::array<double, std::size_t{kDriftStates} * kDriftStates>;  // row-major
struct DriftEvidence;

struct StillOptions {
  double length_m = 0.02, angle_rad = 0.3;  // the core forgets while the pen goes so far or turns so much ...
  double forget_s = 1;                      // ... but takes so long
  double share = 0.1, sigmas = 4;           // of these, or standard deviations of noise: within, the pen lies still
  double settle_s = 1, reference_s = 1;     // then a reference is taken, over so long ...
  double reference_max_s = 16;              // ... and made better, until then
};

// Where the pen is, from the core's centre.
struct PenPlace {
  base::Vec3 position_base_m, axis_base;
  base::Vec3 core_A;                                // the core's moment in its field, as currents
  double position_sigma_m = 0, axis_sigma_rad = 0;  // of its noise
};

struct StillPen {
  double still_s = 0;  // since the pen was at:
  PenPlace place;      // its mean over settle_s
  bool referenced = false;
  bool gathers = true;  // scans make the reference better
  // Of the reference's scans, sums; then its solution, what the model gets wrong in the states' terms, the states'
  // covariance then, and that of what they have changed by since.
  DriftMatrix information{}, reference_covariance{}, covariance{};
  DriftVector gradient{}, reference{};
};
static_assert(std::is_trivially_copyable_v<StillPen>);

// How often the core has forgotten, by e, since the last call; null: the pen may be anywhere. Nothing while it lies
// still. core_kept_A: what the core keeps of a motion; 0: unknown.
double ForgottenOf(const StillOptions& options, double dt_s, const PenPlace* pen, double core_kept_A,
                   StillPen& still) noexcept;

// A scan of a pen that lies still: gathers the reference, or leaves of what it says what has changed since that.
// covariance: of the states themselves.
void TellChange(const StillOptions& options, const DriftMatrix& covariance, StillPen& still,
                DriftEvidence& evidence) noexcept;

}  // namespace omni::tracker
