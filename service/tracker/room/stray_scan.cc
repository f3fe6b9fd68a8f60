#include "service/tracker/room/stray_scan.h"

#include <algorithm>
#include <cmath>

#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kCoils = base::kCoilCount;
constexpr int kEliminated = static_cast<int>(StrayScan::kEliminated);
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
  AsMatrix<kEliminated>(H) = AsRows(scan.columns) * AsRows(scan.columns).transpose();
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
    const auto of_sensor = Eigen::seqN(static_cast<int>(i), Eigen::fix<3>, Eigen::fix<static_cast<int>(kSensors)>);
    Matrix<3, 1> c = Matrix<3, 1>::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double inverse_sigma = scan.inverse_sigma[kSensors * axis + i];
      if (inverse_sigma != 0) c[static_cast<int>(axis)] = inverse_sigma * of_axis_T[axis];  // else perhaps no number
    }
    const Matrix<kEliminated, 3> columns = AsRows(scan.columns)(Eigen::all, of_sensor);
    const Matrix<kEliminated, 3> gain = AsRows(scan.gain)(Eigen::all, of_sensor);
    evidence.gain_information[i] += c.squaredNorm() - (columns * c).dot(gain * c);
    evidence.gain_gradient[i] -= c.dot(AsVector(rest)(of_sensor));
  }
}

}  // namespace

ReadingLanes StrayScan::Eliminate(const ReadingLanes& column) const noexcept {
  ReadingLanes left;
  AsVector(left) = AsVector(column) - AsRows(columns).transpose() * (AsRows(gain) * AsVector(column));
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
  const auto inverse_sigma = AsVector(scan.inverse_sigma);
  Rows residual;
  AsVector(residual) = AsVector(scan.residual) - inverse_sigma.cwiseProduct(AsVector(offset_T));
  const Rows rest = scan.Eliminate(residual);
  const Matrix<kEliminated, kReadings> columns = AsRows(scan.columns) * inverse_sigma.asDiagonal();
  const Matrix<kEliminated, kReadings> gain = AsRows(scan.gain) * inverse_sigma.asDiagonal();
  auto information_1_T2 = AsMatrix<kReadings>(evidence.information_1_T2);
  information_1_T2 -= columns.transpose() * gain;
  information_1_T2.diagonal() += inverse_sigma.cwiseAbs2();
  AsVector(evidence.gradient_1_T) -= inverse_sigma.cwiseProduct(AsVector(rest));
  AddGains(scan, readings, rest, evidence);
  evidence.misfit += Dot(residual, rest);
  ++evidence.scans;
}

void AddEvidence(double keep, double share, const StrayEvidence& evidence, StrayEvidence& sum) noexcept {
  const auto add = [=](const auto& now, auto& all) { AsVector(all) = keep * AsVector(all) + share * AsVector(now); };
  add(evidence.information_1_T2, sum.information_1_T2);
  add(evidence.gradient_1_T, sum.gradient_1_T);
  add(evidence.gain_information, sum.gain_information);
  add(evidence.gain_gradient, sum.gain_gradient);
  sum.misfit = keep * sum.misfit + share * evidence.misfit;
  sum.scans = keep * sum.scans + share * evidence.scans;
}

}  // namespace omni::tracker
