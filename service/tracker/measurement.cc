#include "service/tracker/measurement.h"

#include <cmath>
#include <limits>

#include "service/base/stamp.h"
#include "service/tracker/nuisance.h"

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
  const double dt_s = base::Elapsed_s(scan.t_ns, previous.t_ns);
  if (!previous.valid || !ArePlausible(previous.coil_current_A)) return rate_A_s;
  if (!(dt_s > 0 && dt_s <= kScanGapMax_s)) return rate_A_s;
  for (std::size_t k = 0; k < rate_A_s.size(); ++k) {
    rate_A_s[k] = (scan.coil_current_A[k] - previous.coil_current_A[k]) / dt_s;
  }
  return rate_A_s;
}

double Square(double x) noexcept { return x * x; }

// The coils' field at one sensor, in its axes, and its rate.
struct CoilField {
  std::array<double, 3> field_T{}, rate_T_s{};
};

// A_i (I + dI/dt (time from the middle of the current's tick to this sample))
CoilField CoilsAt(const Model& model, std::size_t i, const Currents& current_A, const Currents& rate_A_s,
                  double since_current_s) noexcept {
  CoilField coils;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* row = &model.coil_map_T_A[(3 * i + axis) * base::kCoilCount];
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      coils.field_T[axis] += row[k] * (current_A[k] + rate_A_s[k] * since_current_s);
      coils.rate_T_s[axis] += row[k] * rate_A_s[k];
    }
  }
  return coils;
}

// Adds sensor i. y_i = B_i - A_i I_i - background; the axes of a sensor share the variance
//   systematic = (eps |y_i|)^2 + (eps_c |A_i I|)^2 + (|A_i dI/dt| age error)^2          docs/theory/tracking.md (3)
template <int kCapacity>
double AddSensor(const Model& model, const Trust& trust, const base::Vec3& B, unsigned saturated_axes,
                 const CoilField& coils, std::size_t i, BasicMeasurement<kCapacity>& result) noexcept {
  const std::array<double, 3> field_T{B.x, B.y, B.z};
  std::array<double, 3> tool_T{};
  std::array<bool, 3> usable{};
  double tool_square = 0, coil_square = 0, rate_square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    tool_T[axis] = field_T[axis] - coils.field_T[axis] - model.background_sensor_T[axis][i];
    usable[axis] = ((saturated_axes >> axis) & 1u) == 0 && std::abs(tool_T[axis]) <= trust.field_max_T;
    if (usable[axis]) tool_square += Square(tool_T[axis]);
    coil_square += Square(coils.field_T[axis]);
    rate_square += Square(coils.rate_T_s[axis]);
  }
  const double systematic = Square(trust.model_error_relative) * tool_square +
                            Square(trust.coil_error_relative) * coil_square + Square(trust.age_error_s) * rate_square;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!usable[axis]) continue;
    const double inverse_sigma = 1 / std::sqrt(Square(model.noise_T[axis]) + systematic);
    for (std::size_t column = 0; column < 3; ++column) {
      result.weight[3 * axis + column][i] = inverse_sigma * model.gain_sensor_base[3 * axis + column][i];
    }
    result.whitened[axis][i] = inverse_sigma * tool_T[axis];
    result.inverse_sigma[axis][i] = inverse_sigma;
    result.systematic_share += systematic * inverse_sigma * inverse_sigma;
    ++result.axes;
  }
  return tool_square;
}

// Variance of what is left of each current after its measured value was subtracted; infinite: no prior.
Currents CurrentVariance(const Trust& trust, const Currents& current_A, const Currents& change_A) noexcept {
  Currents variance_A2{};
  for (std::size_t k = 0; k < variance_A2.size(); ++k) {
    variance_A2[k] = trust.currents_hidden
                         ? std::numeric_limits<double>::infinity()
                         : Square(trust.current_error_A) + Square(trust.current_error_relative * current_A[k]) +
                               Square(trust.current_change_error * change_A[k]) + Square(trust.remanence_A);
  }
  return variance_A2;
}

}  // namespace

Trust NoiseOnly() noexcept {
  Trust trust;
  trust.model_error_relative = trust.coil_error_relative = trust.age_error_s = 0;
  trust.current_error_A = trust.current_error_relative = trust.current_change_error = 0;
  return trust;
}

// t_ns = (tick end) - lead, and ticks end every millisecond: lead grows by what the stamp fell behind the tick count.
// Free-running sensors make lead touch zero every few hundred scans; there the tick's end is seen. The slow leak
// follows a drifting device clock.
CurrentHistory Remember(const base::HallScan& scan, const CurrentHistory& previous) noexcept {
  CurrentHistory now{true, scan.t_ns, scan.sequence, scan.coil_current_A, 0};
  const double elapsed_s = base::Elapsed_s(scan.t_ns, previous.t_ns);
  const std::uint64_t ticks = scan.sequence - previous.sequence;
  if (!previous.valid || !(ticks >= 1 && ticks <= kTickGapMax)) return now;
  const double lead_s =
      previous.stamp_lead_s + static_cast<double>(ticks) * (base::kTickPeriod_s - kLeak_s) - elapsed_s;
  now.stamp_lead_s = lead_s > 0 && lead_s < base::kTickPeriod_s ? lead_s : 0.0;
  return now;
}

Measurement MakeMeasurement(const Model& model, const Trust& trust, const base::HallScan& scan,
                            const CurrentHistory& previous, const CurrentHistory& now,
                            const Offsets& offsets) noexcept {
  Measurement result;
  result.sensors = kSensors;
  const bool known = !trust.currents_hidden;
  if (known && !ArePlausible(scan.coil_current_A)) return result;  // the coils' share is unknown: nothing is usable
  const Currents measured_A = known ? scan.coil_current_A : Currents{};
  const Currents rate_A_s = known ? CurrentRate(scan, previous) : Currents{};
  Currents current_A{};
  for (std::size_t k = 0; k < current_A.size(); ++k) current_A[k] = measured_A[k] + offsets.remanence_A[k];
  double square_sum = 0;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!(scan.age_ns[i] >= 0 && scan.age_ns[i] <= trust.age_max_ns)) continue;
    result.age_s[i] = 1e-9 * static_cast<double>(scan.age_ns[i]);
    const double since_current_s = trust.current_age_s - now.stamp_lead_s - result.age_s[i];
    CoilField coils = CoilsAt(model, i, current_A, rate_A_s, since_current_s);
    for (std::size_t e = 0; e < 9; ++e)
      coils.field_T[e / 3] += model.gain_sensor_base[e][i] * offsets.ambient_base_T[e % 3];
    square_sum +=
        AddSensor(model, trust, scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7u, coils, i, result);
  }
  if (result.axes > 0) {
    result.field_rms_T = std::sqrt(3 * square_sum / result.axes);
    result.systematic_share /= result.axes;
  }
  Currents change_A{};
  for (std::size_t k = 0; k < change_A.size(); ++k) {
    change_A[k] = rate_A_s[k] != 0 ? measured_A[k] - previous.coil_current_A[k] : 0.0;
  }
  Currents variance_A2 = CurrentVariance(trust, measured_A, change_A);
  result.current_variance_A2 = variance_A2;
  for (std::size_t k = 0; k < variance_A2.size(); ++k) variance_A2[k] += offsets.remanence_variance_A2[k];
  SetNuisances(model, variance_A2, Square(trust.ambient_error_T), result);
  return result;
}

void MakeArrayMeasurement(const Model& model, const Trust& trust, const ArrayReading* readings,
                          const std::array<double, base::kCoilCount>& coil_current_A,
                          ArrayMeasurement& result) noexcept {
  result = {};
  result.sensors = model.sensors;
  const Currents current_A = trust.currents_hidden ? Currents{} : coil_current_A;
  if (!ArePlausible(current_A)) return;
  double square_sum = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(model.sensors); ++i) {
    square_sum += AddSensor(model, trust, readings[i].field_sensor_T, readings[i].saturated_axes,
                            CoilsAt(model, i, current_A, {}, 0), i, result);
  }
  if (result.axes > 0) result.field_rms_T = std::sqrt(3 * square_sum / result.axes);
  SetNuisances(model, CurrentVariance(trust, current_A, {}), Square(trust.ambient_error_T), result);
}

}  // namespace omni::tracker
