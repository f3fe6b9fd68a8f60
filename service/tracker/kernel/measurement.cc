#include "service/tracker/kernel/measurement.h"

#include <cmath>
#include <limits>

namespace omni::tracker {
namespace {

double Square(double x) noexcept { return x * x; }

// The coils' field at one sensor, in its axes, and its rate.
struct CoilField {
  std::array<double, 3> field_T{}, rate_T_s{};
};

// A_i I
CoilField CoilsAt(const Model& model, std::size_t i, const CurrentInstant& coils_at) noexcept {
  CoilField coils;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* row = &model.coil_map_T_A[(3 * i + axis) * base::kCoilCount];
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      coils.field_T[axis] += row[k] * coils_at.current_A[k];
      coils.rate_T_s[axis] += row[k] * coils_at.rate_A_s[k];
    }
  }
  return coils;
}

// Adds sensor i. y_i = B_i - A_i I_i - background; the axes of a sensor share the variance
//   systematic = (eps |y_i|)^2 + (eps_c |A_i I|)^2 + (|A_i dI/dt| age error)^2          docs/theory/tracking.md (3.1)
template <int kCapacity>
double AddSensor(const Model& model, const Trust& trust, const base::Vec3& B, unsigned saturated_axes,
                 const CoilField& coils, const std::array<double, 3>& offset_variance_T2, std::size_t i,
                 BasicMeasurement<kCapacity>& result) noexcept {
  const std::array<double, 3> field_T{B.x, B.y, B.z};
  std::array<double, 3> tool_T{};
  std::array<bool, 3> usable{};
  double tool_square = 0, coil_square = 0, rate_square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    tool_T[axis] = field_T[axis] - coils.field_T[axis] - model.background_sensor_T[axis][i];
    usable[axis] = ((saturated_axes >> axis) & 1u) == 0 && std::abs(tool_T[axis]) <= model.field_max_T;
    if (usable[axis]) tool_square += Square(tool_T[axis]);
    coil_square += Square(coils.field_T[axis]);
    rate_square += Square(coils.rate_T_s[axis]);
  }
  const double systematic = Square(trust.model_error_relative) * tool_square +
                            Square(trust.coil_error_relative) * coil_square + Square(trust.age_error_s) * rate_square;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!usable[axis]) continue;
    const double inverse_sigma = 1 / std::sqrt(Square(model.noise_T[axis]) + systematic + offset_variance_T2[axis]);
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
Currents CurrentVariance(const Trust& trust, const Currents& current_A, const Currents& change_A,
                         double change_error) noexcept {
  Currents variance_A2{};
  for (std::size_t k = 0; k < variance_A2.size(); ++k) {
    variance_A2[k] = trust.currents_hidden
                         ? std::numeric_limits<double>::infinity()
                         : Square(trust.current_error_A) + Square(trust.current_error_relative * current_A[k]) +
                               Square(change_error * change_A[k]);
  }
  return variance_A2;
}

}  // namespace

double RootMeanSquare(const ReadingLanes& values) noexcept {
  return std::sqrt(Dot(values, values) / static_cast<double>(values.size()));
}

Trust NoiseOnly() noexcept {
  Trust trust;
  trust.model_error_relative = trust.coil_error_relative = trust.age_error_s = 0;
  trust.current_error_A = trust.current_error_relative = 0;
  trust.current_step_error = trust.current_change_error = 0;
  return trust;
}

Measurement MakeMeasurement(const Model& model, const Trust& trust, const base::HallScan& scan,
                            const CurrentHistory& previous, const CurrentHistory& now,
                            const Offsets& offsets) noexcept {
  Measurement result;
  result.sensors = kSensors;
  const bool known = !trust.currents_hidden;
  const CoilCurrents currents(scan, previous, now, trust.current_age_s);
  if (known && !currents.plausible()) return result;  // the coils' share is unknown: nothing is usable
  double square_sum = 0;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!base::IsFreshSample(scan, i)) continue;
    if (((trust.sensors_out >> i) & 1u) != 0) continue;
    result.age_s[i] = 1e-9 * static_cast<double>(scan.age_ns[i]);
    CurrentInstant then = known ? currents.At(result.age_s[i]) : CurrentInstant{};
    for (std::size_t k = 0; k < base::kCoilCount; ++k) then.current_A[k] += offsets.remanence_A[k];
    CoilField coils = CoilsAt(model, i, then);
    std::array<double, 3> offset_T = offsets.ambient_base_T;
    for (std::size_t c = 0; c < 3; ++c) {
      const AmbientChange& mains = offsets.mains;
      const double age_s = result.age_s[i];
      offset_T[c] += mains.field_T[c] - age_s * (mains.rate_T_s[c] - 0.5 * age_s * mains.acceleration_T_s2[c]);
      if (offsets.local_base_T != nullptr) offset_T[c] += (*offsets.local_base_T)[c][i];
    }
    for (std::size_t e = 0; e < 9; ++e) coils.field_T[e / 3] += model.gain_sensor_base[e][i] * offset_T[e % 3];
    std::array<double, 3> variance_T2{};
    for (std::size_t axis = 0; axis < 3 && offsets.reading_T != nullptr; ++axis) {
      coils.field_T[axis] += (*offsets.reading_T)[kSensors * axis + i];
      variance_T2[axis] = (*offsets.reading_variance_T2)[kSensors * axis + i];
    }
    square_sum += AddSensor(model, trust, scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7u, coils,
                            variance_T2, i, result);
  }
  if (result.axes > 0) {
    result.field_rms_T = std::sqrt(3 * square_sum / result.axes);
    result.systematic_share /= result.axes;
  }
  const double change_error = now.has_steps ? trust.current_step_error : trust.current_change_error;
  Currents variance_A2 = CurrentVariance(trust, scan.coil_current_A, currents.change_A(), change_error);
  result.current_variance_A2 = variance_A2;
  for (std::size_t k = 0; k < variance_A2.size(); ++k) variance_A2[k] += offsets.remanence_variance_A2[k];
  std::array<double, 3> ambient_T2 = offsets.ambient_variance_T2;
  for (double& variance : ambient_T2) variance += Square(trust.ambient_error_T);
  SetNuisances(model, variance_A2, ambient_T2, result);
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
                            CoilsAt(model, i, {current_A, {}}), {}, i, result);
  }
  if (result.axes > 0) result.field_rms_T = std::sqrt(3 * square_sum / result.axes);
  const double ambient_T2 = Square(trust.ambient_error_T);
  SetNuisances(model, CurrentVariance(trust, current_A, {}, 0), {ambient_T2, ambient_T2, ambient_T2}, result);
}

}  // namespace omni::tracker
