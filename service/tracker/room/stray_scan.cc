#include "service/tracker/room/stray_scan.h"

#include <algorithm>
#include <cmath>

#include "service/tracker/kernel/cholesky.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kRows = kReadings;
constexpr std::size_t kCoils = base::kCoilCount;
constexpr std::size_t kEliminated = StrayScan::kEliminated;
constexpr double kCurrentMin_A2 = 1e-12, kMomentMin = 1e-8;  // variances of what is known well
constexpr double kWhiteMin = 1e-3;  // of a reading's variance: what is its own, where its offset is unknown

using Rows = ReadingLanes;

void Linearise(const Model& model, const Measurement& measurement, const Pose& pose, const Rows& offset_T,
               const Rows* variance_T2, StrayScan& scan) noexcept {
  const KernelPose at = ToKernel(MakePosePoint(pose), measurement.velocity_base_m_s, measurement.axis_rate_base_1_s);
  BlockField field;
  ActiveKernel().field(model.places[0], model.tool, at, field);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kSensors; ++i) {
      const std::size_t row = kSensors * axis + i;
      const double with_offset = measurement.inverse_sigma[axis][i];
      if (with_offset == 0) continue;
      const double unknown_T2 = variance_T2 != nullptr ? (*variance_T2)[row] : 0.0;
      const double raise = 1 / std::sqrt(std::max(kWhiteMin, 1 - unknown_T2 * with_offset * with_offset));
      scan.inverse_sigma[row] = raise * with_offset;
      double tool = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        const double weight = raise * measurement.weight[3 * axis + c][i];
        const double of_tool = weight * measurement.moment_scale;
        tool += of_tool * field.B_T[c][i];
        for (std::size_t k = 0; k < kParameters; ++k) scan.columns[k][row] += of_tool * field.derivative[k][c][i];
        scan.columns[StrayScan::kAmbient + c][row] = weight;
      }
      for (std::size_t k = 0; k < kCoils; ++k) {
        scan.columns[kParameters + k][row] = scan.inverse_sigma[row] * model.coil_map_T_A[(3 * i + axis) * kCoils + k];
      }
      scan.columns[StrayScan::kMoment][row] = tool;
      scan.residual[row] = tool - raise * measurement.whitened[axis][i];
      if (variance_T2 == nullptr) scan.residual[row] += scan.inverse_sigma[row] * offset_T[row];
      for (std::size_t k = 0; k < kParameters; ++k) {
        scan.residual[row] -= measurement.age_s[i] * at.rate_1_s[k] * scan.columns[k][row];
      }
    }
  }
}

// No prior of pose and ambient field: the knowledge of that field was learnt with the offsets taken for known.
bool SetGain(const Measurement& measurement, const DriftState& drift, StrayScan& scan) noexcept {
  std::array<double, kEliminated * kEliminated> H;
  for (std::size_t a = 0; a < kEliminated; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      H[a * kEliminated + b] = H[b * kEliminated + a] = Dot(scan.columns[a], scan.columns[b]);
    }
  }
  const auto drift_variance = [&](std::size_t state) { return drift.covariance[state * (kDriftStates + 1)]; };
  for (std::size_t k = 0; k < kCoils; ++k) {
    const double variance_A2 = measurement.current_variance_A2[k] + drift_variance(k);
    H[(kParameters + k) * (kEliminated + 1)] += 1 / std::max(variance_A2, kCurrentMin_A2);
  }
  H[StrayScan::kMoment * (kEliminated + 1)] += 1 / std::max(drift_variance(kNuisancesMax), kMomentMin);
  SmallCholesky<kEliminated> factors;
  if (!factors.Factor(H.data(), kEliminated, 0)) return false;
  scan.gain = scan.columns;
  factors.SolveSides(scan.gain);
  return true;
}

// Of every sensor's gain; a column of it has three rows only. rest: Q r0.
void AddGains(const StrayScan& scan, const base::HallScan& readings, const Rows& rest,
              StrayEvidence& evidence) noexcept {
  for (std::size_t i = 0; i < kSensors; ++i) {
    const base::Vec3& read_T = readings.field_sensor_T[i];
    const std::array<double, 3> of_axis_T{read_T.x, read_T.y, read_T.z};
    std::array<double, 3> c{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t row = kSensors * axis + i;
      if (scan.inverse_sigma[row] == 0) continue;  // perhaps it is no number
      c[axis] = scan.inverse_sigma[row] * of_axis_T[axis];
      evidence.gain_information[i] += c[axis] * c[axis];
      evidence.gain_gradient[i] -= c[axis] * rest[row];
    }
    for (std::size_t e = 0; e < kEliminated; ++e) {
      double column = 0, gain = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        column += scan.columns[e][kSensors * axis + i] * c[axis];
        gain += scan.gain[e][kSensors * axis + i] * c[axis];
      }
      evidence.gain_information[i] -= column * gain;
    }
  }
}

}  // namespace

ReadingLanes StrayScan::Eliminate(const ReadingLanes& column) const noexcept {
  ReadingLanes left = column;
  for (std::size_t e = 0; e < kEliminated; ++e) {
    const double size = Dot(gain[e], column);
    for (std::size_t row = 0; row < kRows; ++row) left[row] -= columns[e][row] * size;
  }
  return left;
}

bool MakeStrayScan(const Model& model, const DriftState& drift, const Measurement& measurement, const Pose& pose,
                   const ReadingLanes& offset_T, const ReadingLanes* variance_T2, StrayScan& scan) noexcept {
  scan = {};
  Linearise(model, measurement, pose, offset_T, variance_T2, scan);
  return SetGain(measurement, drift, scan);
}

void AddScan(const StrayScan& scan, const base::HallScan& readings, const ReadingLanes& offset_T,
             StrayEvidence& evidence) noexcept {
  Rows residual;
  for (std::size_t row = 0; row < kRows; ++row) {
    residual[row] = scan.residual[row] - scan.inverse_sigma[row] * offset_T[row];
  }
  const Rows rest = scan.Eliminate(residual);
  std::array<Rows, kEliminated> gain = scan.gain;
  for (Rows& row : gain) {
    for (std::size_t b = 0; b < kRows; ++b) row[b] *= scan.inverse_sigma[b];
  }
  for (std::size_t a = 0; a < kRows; ++a) {
    const double weight = scan.inverse_sigma[a];
    Rows eliminated{};
    for (std::size_t e = 0; e < kEliminated; ++e) {
      const double factor = weight * scan.columns[e][a];
      for (std::size_t b = 0; b < kRows; ++b) eliminated[b] += factor * gain[e][b];
    }
    double* row = &evidence.information_1_T2[a * kRows];
    for (std::size_t b = 0; b < kRows; ++b) row[b] -= eliminated[b];
    row[a] += weight * scan.inverse_sigma[a];
    evidence.gradient_1_T[a] -= weight * rest[a];
  }
  AddGains(scan, readings, rest, evidence);
  evidence.misfit += Dot(residual, rest);
  ++evidence.scans;
}

void AddEvidence(double keep, double share, const StrayEvidence& evidence, StrayEvidence& sum) noexcept {
  for (std::size_t e = 0; e < sum.information_1_T2.size(); ++e) {
    sum.information_1_T2[e] = keep * sum.information_1_T2[e] + share * evidence.information_1_T2[e];
  }
  for (std::size_t a = 0; a < kRows; ++a) {
    sum.gradient_1_T[a] = keep * sum.gradient_1_T[a] + share * evidence.gradient_1_T[a];
  }
  for (std::size_t i = 0; i < kSensors; ++i) {
    sum.gain_information[i] = keep * sum.gain_information[i] + share * evidence.gain_information[i];
    sum.gain_gradient[i] = keep * sum.gain_gradient[i] + share * evidence.gain_gradient[i];
  }
  sum.misfit = keep * sum.misfit + share * evidence.misfit;
  sum.scans = keep * sum.scans + share * evidence.scans;
}

}  // namespace omni::tracker
