// What changes slowly and is the same for many scans: field kept by the core (as currents), ambient field since the
// background was measured, and the magnet's moment (0.12 % per kelvin). Seven states, estimated from scans whose pose
// is eliminated. docs/theory/tracking.md (9.1) - (9.3)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

// A pen that lies still: the model's error there is the same in every scan, so that scans show changes only, and these
// as exactly as their noise allows. docs/theory/tracking.md (9.7)
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

// Each state wanders about zero, with this rms and this relaxation time.
struct DriftNoise {
  bool enabled = true;
  int every_scans = 4;         // a scan evaluated for them costs half as much again
  double remanence_A = 0.011;  // 0: nothing is estimated
  double core_kept_A = 0;      // after any motion, from the calibration: then the core is followed; 0: unknown
  double core_error = 0.4, core_error_min_A = 0.002;  // rms error of that: relative, at least
  double coil_core_share = 0.5;                       // of a coil's moment, which is the core's
  StillOptions still;                                 // when the core's state is forgotten
  double ambient_T = 5e-7, ambient_s = 100;
  // Factor on the growth of this variance and of the moment's while the pen lies still: slow changes have time to be
  // seen.
  double still_grows = 1e-2;
  // A field that changes faster than that: the base is turned or carried, iron comes near. How far it may have jumped
  // when nothing else explains a scan, and the bounds, in T^2/s, between which its wander is learnt from the
  // innovations.
  double ambient_jump_T = 1e-4;
  double ambient_wander_min_T2_s = 1e-15, ambient_wander_max_T2_s = 1e-9;
  double ambient_open_T = 6e-7;          // a field known less well is an unknown of every scan
  double moment = 0.01, moment_s = 2e4;  // 0.01 % in a second
  double moment_max = 0.05;              // from that of the pen in use
  // The model's error stays the same from scan to scan until the pen has moved, turned or waited so much.
  double same_error_m = 0.02, same_error_rad = 0.3, same_error_s = 10;
};

struct DriftState {
  bool valid = false;
  std::int64_t t_ns = 0;           // of the last prediction
  double step_s = 0;               // bridged by it
  double ambient_wander_T2_s = 0;  // beyond what DriftNoise says
  // Means over the last scans of the evidence that the ambient field has moved, as information and gradient.
  std::array<double, 9> recent_information{};
  std::array<double, 3> recent_gradient{};
  DriftVector mean{};
  DriftMatrix covariance{};
  double moment_of_pen = 0;  // mean of the moment's state: that of the pen in use
  bool moment_open = false;  // which pen that is, is not known
  bool core_followed = false;
  std::array<double, base::kCoilCount> core_A{};  // the core's moment, as currents, if core_followed
  StillPen still;
};
static_assert(std::is_trivially_copyable_v<DriftState>);

// What one scan says about the seven states, its pose eliminated at the solution of the linearised scan:
//   information I = A - B H^-1 B^T,   gradient g = -(c - B H^-1 J^T r)
// with A = [C^T C, C^T M; M^T C, M^T M], B = [C^T J; M^T J], c = [C^T r; M^T r], H = J^T J.
struct DriftEvidence {
  bool valid = false;
  DriftMatrix information{};
  DriftVector gradient{};
  double share = 0;  // share of both that is used
  double systematic_share = 0;
  double age_s = 0;                                   // of the samples, the mean
  std::array<double, kParameters> pose_per_moment{};  // shift of the fitted pose with the moment's state
  std::array<double, base::kCoilCount> current_variance_A2{};
};
static_assert(std::is_trivially_copyable_v<DriftEvidence>);

Offsets OffsetsOf(const DriftNoise& noise, const DriftState& drift) noexcept;
double MomentScale(const DriftState& drift) noexcept;
double MomentVariance(const DriftState& drift) noexcept;                 // of it
std::array<double, 3> AmbientField_T(const DriftState& drift) noexcept;  // frame B, since the calibration

// For each scan, before it is measured: drags the core's remanence behind its moment. pen: null: it may be anywhere,
// and the core is not followed.
void FollowCore(const DriftNoise& noise, const std::array<double, base::kCoilCount>& coil_current_A,
                const PenPlace* pen, DriftState& drift) noexcept;

// Relaxes the states to a scan's time; an invalid state starts at zero with its full variance. pen: null: it may be
// anywhere.
void PredictDrift(const DriftNoise& noise, std::int64_t t_ns, const PenPlace* pen, DriftState& drift) noexcept;

// Number of scans, step_s apart, in which the model's own error is the same: n of (9.6).
double RepeatsOf(const DriftNoise& noise, const Measurement& measurement, double step_s) noexcept;

// Share of new information in each of `repeats` scans if that error is the share `systematic` of their variance: f of
// (9.6).
double EvidenceShare(double repeats, double systematic) noexcept;

// `sums`: of a fit of a measurement with the columns of AddAmbientColumns; step_s: since the evidence before.
DriftEvidence GatherEvidence(const DriftNoise& noise, const Measurement& measurement, const KernelSums& sums,
                             double step_s) noexcept;

// Sets the ambient field, with this variance per axis.
void SetAmbient(const std::array<double, 3>& ambient_base_T, double variance_T2, DriftState& drift) noexcept;
void WidenAmbient(double variance_T2, DriftState& drift) noexcept;

// The ambient field may have jumped: its variance becomes noise.ambient_jump_T squared, and the last scans' evidence is
// dropped.
void OpenAmbient(const DriftNoise& noise, DriftState& drift) noexcept;

// The ambient field changes faster than DriftNoise says, or is poorly known: every scan is evaluated.
bool IsAmbientLively(const DriftNoise& noise, const DriftState& drift) noexcept;

// The moment is this, relative to the model's, with that variance; it may be any pen's.
void SetMoment(double relative, double variance, DriftState& drift) noexcept;
// It was measured otherwise.
void ObserveMoment(double relative, double variance, DriftState& drift) noexcept;
// It is that of a pen whose moment is this, and stays near it.
void HoldMoment(double relative, DriftState& drift) noexcept;

// What a scan says of the moment alone, as information and gradient: the other states are eliminated, each known to its
// own variance.
struct MomentEvidence {
  bool valid = false;
  double information = 0, gradient = 0;
};
MomentEvidence OfMoment(DriftEvidence evidence, const DriftState& drift) noexcept;

// What a scan says of the ambient field alone, as information (row-major, 1/T^2) and gradient: the other states are
// eliminated, each known to its own variance.
struct AmbientEvidence {
  bool valid = false;
  std::array<double, 9> information{};
  std::array<double, 3> gradient{};
};

// Before the next PredictDrift. Returns the evidence about the ambient field; not valid: nothing usable.
AmbientEvidence CorrectDrift(const DriftNoise& noise, DriftEvidence evidence, DriftState& drift) noexcept;

}  // namespace omni::tracker
