#include "service/tracker/measurement.h"

#include <Eigen/LU>
#include <cmath>

namespace omni::tracker {
namespace {

constexpr double kScanGapMax_s = 5e-3;  // currents are not interpolated over a longer gap
constexpr std::uint64_t kTickGapMax = 20;
constexpr double kLeak_s = 1e-7;       // per tick: 100 ppm
constexpr double kCurrentMax_A = 1e3;  // a larger value is no current

using Currents = std::array<double, base::kCoilCount>;

bool ArePlausible(const Currents& current_A) noexcept {
  for (const double current : current_A) {
    if (!(std::abs(current) <= kCurrentMax_A)) return false;
  }
  return true;
}

// dI/dt between two scans; zero when the scan before is missing or too old.
Currents CurrentRate(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  Currents rate_A_s{};
  const double dt_s = 1e-9 * (static_cast<double>(scan.t_ns) - static_cast<double>(previous.t_ns));
  if (!previous.valid || !ArePlausible(previous.coil_current_A)) return rate_A_s;
  if (!(dt_s > 0 && dt_s <= kScanGapMax_s)) return rate_A_s;
  for (std::size_t k = 0; k < rate_A_s.size(); ++k) {
    rate_A_s[k] = (scan.coil_current_A[k] - previous.coil_current_A[k]) / dt_s;
  }
  return rate_A_s;
}

// One sensor without the coils' share, and the variance that its axes have in common.
struct Reading {
  std::array<double, 3> tool_T{};
  std::array<bool, 3> usable{};
  double tool_square_T2 = 0;
  double systematic_T2 = 0;
};

double Square(double x) noexcept { return x * x; }

// y_i = B_i - A_i (I + dI/dt (time from the middle of the current's tick to this sample))
// systematic = (eps |y_i|)^2 + (eps_c |A_i I|)^2 + (|A_i dI/dt| age error)^2
Reading SeparateTool(const Model& model, const Trust& trust, const base::HallScan& scan, const Currents& rate_A_s,
                     std::size_t i, double since_current_s) noexcept {
  Reading reading;
  const base::Vec3& B = scan.field_sensor_T[i];
  const std::array<double, 3> field_T{B.x, B.y, B.z};
  double coil_square = 0, rate_square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* row = &model.coil_map_T_A[(3 * i + axis) * base::kCoilCount];
    double coil_T = 0, rate_T_s = 0;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      coil_T += row[k] * (scan.coil_current_A[k] + rate_A_s[k] * since_current_s);
      rate_T_s += row[k] * rate_A_s[k];
    }
    reading.tool_T[axis] = field_T[axis] - coil_T - model.background_sensor_T[axis][i];
    const bool saturated = (scan.saturated_mask >> (3 * i + axis)) & 1u;
    reading.usable[axis] = !saturated && std::abs(reading.tool_T[axis]) <= trust.field_max_T;
    if (reading.usable[axis]) reading.tool_square_T2 += Square(reading.tool_T[axis]);
    coil_square += Square(coil_T);
    rate_square += Square(rate_T_s);
  }
  reading.systematic_T2 = Square(trust.model_error_relative) * reading.tool_square_T2 +
                          Square(trust.coil_error_relative) * coil_square + Square(trust.age_error_s) * rate_square;
  return reading;
}

void SetSensor(const Model& model, const Reading& reading, std::size_t i, Measurement& result) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!reading.usable[axis]) continue;
    const double inverse_sigma = 1 / std::sqrt(Square(model.noise_T[axis]) + reading.systematic_T2);
    for (std::size_t column = 0; column < 3; ++column) {
      result.weight[3 * axis + column][i] = inverse_sigma * model.gain_sensor_base[3 * axis + column][i];
    }
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      result.coil[3 * axis + k][i] = inverse_sigma * model.coil_map_T_A[(3 * i + axis) * base::kCoilCount + k];
    }
    result.whitened[axis][i] = inverse_sigma * reading.tool_T[axis];
    result.inverse_sigma[axis][i] = inverse_sigma;
    ++result.axes;
  }
}

// (C^T C + diag(1/s^2))^-1, s_k the uncertainty of current k.
void SetCoilCovariance(const Trust& trust, const base::HallScan& scan, const CurrentHistory& previous,
                       const Currents& rate_A_s, Measurement& result) noexcept {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kSensors; ++i) {
      const Eigen::Vector3d row(result.coil[3 * axis][i], result.coil[3 * axis + 1][i], result.coil[3 * axis + 2][i]);
      information += row * row.transpose();
    }
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const double change_A = rate_A_s[k] != 0 ? scan.coil_current_A[k] - previous.coil_current_A[k] : 0.0;
    const double variance = Square(trust.current_error_A) +
                            Square(trust.current_error_relative * scan.coil_current_A[k]) +
                            Square(trust.current_change_error * change_A);
    if (!(variance > 0)) return;  // currents are taken as exact
    information(static_cast<int>(k), static_cast<int>(k)) += 1 / variance;
  }
  const Eigen::Matrix3d covariance = information.inverse();
  Eigen::Map<Eigen::Matrix3d>(result.coil_covariance.data()) = covariance;
}

}  // namespace

// t_ns = (tick end) - lead, and ticks end every millisecond: lead grows by what the stamp fell behind the tick count.
// Free-running sensors make lead touch zero every few hundred scans; there the tick's end is seen. The slow leak
// follows a drifting device clock.
CurrentHistory Remember(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  CurrentHistory now{true, scan.t_ns, scan.sequence, scan.coil_current_A, 0};
  const double elapsed_s = 1e-9 * (static_cast<double>(scan.t_ns) - static_cast<double>(previous.t_ns));
  const std::uint64_t ticks = scan.sequence - previous.sequence;
  if (!previous.valid || !(ticks >= 1 && ticks <= kTickGapMax)) return now;
  const double lead_s =
      previous.stamp_lead_s + static_cast<double>(ticks) * (base::kTickPeriod_s - kLeak_s) - elapsed_s;
  now.stamp_lead_s = lead_s > 0 && lead_s < base::kTickPeriod_s ? lead_s : 0.0;
  return now;
}

Measurement MakeMeasurement(const Model& model, const Trust& trust, const base::HallScan& scan,
                            const CurrentHistory& previous, const CurrentHistory& now) noexcept {
  Measurement result;
  if (!ArePlausible(scan.coil_current_A)) return result;  // the coils' share is unknown: nothing is usable
  const Currents rate_A_s = CurrentRate(scan, previous);
  double square_sum = 0;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!(scan.age_ns[i] >= 0 && scan.age_ns[i] <= trust.age_max_ns)) continue;
    result.age_s[i] = 1e-9 * static_cast<double>(scan.age_ns[i]);
    const double since_current_s = trust.current_age_s - now.stamp_lead_s - result.age_s[i];
    const Reading reading = SeparateTool(model, trust, scan, rate_A_s, i, since_current_s);
    SetSensor(model, reading, i, result);
    square_sum += reading.tool_square_T2;
  }
  if (result.axes > 0) result.field_rms_T = std::sqrt(3 * square_sum / result.axes);
  SetCoilCovariance(trust, scan, previous, rate_A_s, result);
  return result;
}

}  // namespace omni::tracker
