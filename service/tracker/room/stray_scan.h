// The scans' evidence of offsets in their readings, with pose, currents, ambient field and moment eliminated.
// docs/theory/tracking.md (13.2)
#pragma once

#include <array>

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/room/drift.h"
#include "service/tracker/solve/solver.h"

namespace omni::tracker {

// One scan, linearised at its pose about offsets x0 of the readings and whitened. A: columns, r: residual,
// D = diag(inverse_sigma); Q = 1 - A (A^T A + prior)^-1 A^T takes out what a column explains.
struct StrayScan {
  static constexpr std::size_t kAmbient = kParameters + base::kCoilCount, kMoment = kAmbient + 3;
  static constexpr std::size_t kEliminated = kMoment + 1;

  ReadingLanes inverse_sigma{};  // 1/T; 0: not used
  ReadingLanes residual{};       // r
  std::array<ReadingLanes, kEliminated> columns{};
  std::array<ReadingLanes, kEliminated> gain{};  // (A^T A + prior)^-1 A^T

  ReadingLanes Eliminate(const ReadingLanes& column) const noexcept;  // Q
};

// offset_T: x0, and the variance with which it was subtracted from the measurement; null: none was. False: nothing
// usable.
bool MakeStrayScan(const Model& model, const DriftState& drift, const Measurement& measurement, const Pose& pose,
                   const ReadingLanes& offset_T, const ReadingLanes* variance_T2, StrayScan& scan) noexcept;

// Misfit of offsets x:   misfit - 2 gradient^T x + x^T information x
// and instead of them of sensor i's gain, wrong by the share e:
//   misfit - 2 gain_gradient[i] e + gain_information[i] e^2
struct StrayEvidence {
  std::array<double, kSensors> gain_information{}, gain_gradient{};
  ReadingMatrix information_1_T2{};
  ReadingLanes gradient_1_T{};
  double misfit = 0;
  double scans = 0;
};

// With r0 = r - D x0, and c what sensor i reads (`readings`), whitened:
//   information += D Q D,   gradient -= D Q r0,   misfit += r0^T Q r0,
//   gain_information[i] += c^T Q c,   gain_gradient[i] -= c^T Q r0
void AddScan(const StrayScan& scan, const base::HallScan& readings, const ReadingLanes& offset_T,
             StrayEvidence& evidence) noexcept;

// sum = keep sum + share evidence
void AddEvidence(double keep, double share, const StrayEvidence& evidence, StrayEvidence& sum) noexcept;

}  // namespace omni::tracker
