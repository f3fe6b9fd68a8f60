// What changes slowly and is the same for many scans: field kept by the core (as currents), ambient field since the
// background was measured, and the magnet's moment (0.12 % per kelvin). Seven states, estimated from scans whose pose
// is eliminated. docs/theory/tracking.md (14) - (16)
#pragma once

#include <array>
#include <type_traits>

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/room/still.h"

namespace omni::tracker {

// Each state wanders about zero: this far (rms), forgetting in this time.
struct DriftNoise {
  bool enabled = true;
  int every_scans = 4;         // a scan that tells of them costs half as much again
  double remanence_A = 0.011;  // 0: nothing is estimated
  double core_kept_A = 0;      // of any motion, by the calibration: then the core is followed; 0: unknown
  double core_error = 0.4, core_error_min_A = 0.002;  // of that, rms of what is kept beside what the motion says
  double coil_core_share = 0.5;                       // of a coil's moment, which is the core's
  StillOptions still;                                 // when the core forgets it
  double ambient_T = 5e-7, ambient_s = 100;
  // While the pen lies still and slow changes have time to be seen, of the growth of these variances.
  double ambient_still = 1e-2, moment_still = 1e-1;
  // A field that changes faster than that: the base is turned or carried, iron comes near. By how much it may have
  // jumped when nothing else explains a scan; what it wanders, in T^2/s, is learnt between these from how far evidence
  // is off.
  double ambient_jump_T = 1e-4;
  double ambient_wander_min_T2_s = 1e-15, ambient_wander_max_T2_s = 1e-9;
  double ambient_open_T = 6e-7;      // known to less than this: an unknown of every scan
  double current_step_error = 0.03;  // of a change of the current: gain and lag of its sensor, hysteresis of the core
  double moment = 0.01, moment_s = 2e4;  // 0.01 % in a second
  double moment_max = 0.05;
  // What the model gets wrong is wrong again in the next scan, until the pen is elsewhere.
  double same_error_m = 0.02, same_error_rad = 0.3, same_error_s = 10;
};

struct DriftState {
  bool valid = false;
  std::int64_t t_ns = 0;           // of the last prediction
  double step_s = 0;               // that it bridged
  double ambient_wander_T2_s = 0;  // beyond what DriftNoise says
  // Of the ambient field, means over the last scans: what they say that it has moved, as information and gradient.
  std::array<double, 9> recent_information{};
  std::array<double, 3> recent_gradient{};
  std::array<double, base::kCoilCount> coil_current_A{};  // at the last correction
  DriftVector mean{};
  DriftMatrix covariance{};
  bool core_followed = false;
  std::array<double, base::kCoilCount> core_A{};  // the core's moment, as currents, if core_followed
  StillPen still;
};
static_assert(std::is_trivially_copyable_v<DriftState>);

// What one scan says about the seven states, its pose eliminated at the solution of the linearised scan:
//   information I = A - B H^-1 B^T,   gradient g = -(c - B H^-1 J^T r)
// with A = [C^T C, C^T M; M^T C, M^T M], B = [C^T J; M^T J], c = [C^T r; M^T r], H = J^T J.
struct DriftEvidence {
  using Row = std::array<double, kDriftStates + 1>;  // by state; the eighth entry fills the vector and stays zero
  bool valid = false;
  std::array<Row, kDriftStates> information{};
  Row gradient{};
  double share = 0;  // of both that counts
  double systematic_share = 0;
  double age_s = 0;  // of the samples, the mean
  std::array<double, base::kCoilCount> current_variance_A2{};
};
static_assert(std::is_trivially_copyable_v<DriftEvidence>);

Offsets OffsetsOf(const DriftNoise& noise, const DriftState& drift) noexcept;
double MomentScale(const DriftState& drift) noexcept;
std::array<double, 3> AmbientField_T(const DriftState& drift) noexcept;  // frame B, since the calibration

// Of each scan, before it is measured: draws what the core keeps behind its moment. The currents and the place of the
// pen; null: it may be anywhere, and the core is not followed.
void FollowCore(const DriftNoise& noise, const std::array<double, base::kCoilCount>& coil_current_A,
                const PenPlace* pen, DriftState& drift) noexcept;

// Forgets for `dt_s`; a state that is not valid starts at zero with its full spread. current_step_A: since the last
// correction; what the sensors of the currents got wrong of it comes on top. pen: null: it may be anywhere.
void PredictDrift(const DriftNoise& noise, double dt_s, const std::array<double, base::kCoilCount>& current_step_A,
                  const PenPlace* pen, DriftState& drift) noexcept;

// In so many scans, step_s apart, the model's own error is the same: n of (18).
double RepeatsOf(const DriftNoise& noise, const Measurement& measurement, double step_s) noexcept;

// Of what each of `repeats` scans says, how much is new, if that error is such a share of their variance: f of (18).
double EvidenceShare(double repeats, double systematic) noexcept;

// `sums`: of a fit of a measurement with the columns of AddAmbientColumns; step_s: since the evidence before.
DriftEvidence GatherEvidence(const DriftNoise& noise, const Measurement& measurement, const KernelSums& sums,
                             double step_s) noexcept;

// The ambient field is that, or may be off by so much more, each way.
void SetAmbient(const std::array<double, 3>& ambient_base_T, double variance_T2, DriftState& drift) noexcept;
void WidenAmbient(double variance_T2, DriftState& drift) noexcept;

// The ambient field may have jumped: it is known to noise.ambient_jump_T, and what the last scans said is forgotten.
void OpenAmbient(const DriftNoise& noise, DriftState& drift) noexcept;

// The ambient field changes faster than DriftNoise says, or is hardly known: every scan is worth looking at.
bool IsAmbientLively(const DriftNoise& noise, const DriftState& drift) noexcept;

// What a scan says of the ambient field alone, as information (row-major, 1/T^2) and gradient: the other states are
// eliminated, each known to its own variance.
struct AmbientEvidence {
  bool valid = false;
  std::array<double, 9> information{};
  std::array<double, 3> gradient{};
};

// Before the next PredictDrift. Returns what the evidence said of the ambient field; not valid: nothing usable.
AmbientEvidence CorrectDrift(const DriftNoise& noise, DriftEvidence evidence, DriftState& drift) noexcept;

}  // namespace omni::tracker
