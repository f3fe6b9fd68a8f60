// A pen that lies still: the model's error there is the same in every scan, so that scans show changes only, and these
// as exactly as their noise allows. docs/theory/tracking.md (9.7)
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
  double length_m = 0.02, angle_rad = 0.3;  // the core's state is forgotten over this travel or turn ...
  double forget_s = 1;                      // ... but no faster than this
  double share = 0.1, sigmas = 4;           // of these, or noise standard deviations: within, the pen lies still
  double settle_s = 1, reference_s = 1;     // then a reference is taken, over this time ...
  double reference_max_s = 16;              // ... and refined until then
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
  bool gathers = true;  // scans refine the reference
  // Sums over the reference's scans; then its solution, the model's error in terms of the states; the states'
  // covariance at that time, and that of their changes since.
  DriftMatrix information{}, reference_covariance{}, covariance{};
  DriftVector gradient{}, reference{};
};
static_assert(std::is_trivially_copyable_v<StillPen>);

// By how many factors of e the core has forgotten since the last call; null: the pen may be anywhere. Zero while it
// lies still. core_kept_A: remanence after a motion; 0: unknown.
double ForgottenOf(const StillOptions& options, double dt_s, const PenPlace* pen, double core_kept_A,
                   StillPen& still) noexcept;

// A scan of a pen that lies still: adds it to the reference, or reduces its evidence to what has changed since then.
// covariance: of the states themselves.
void ReduceToChange(const StillOptions& options, const DriftMatrix& covariance, StillPen& still,
                    DriftEvidence& evidence) noexcept;

}  // namespace omni::tracker
