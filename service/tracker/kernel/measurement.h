// Readings as the solver wants them: the tool's field alone, whitened, with what else may have disturbed them.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/hall_scan.h"
#include "service/tracker/kernel/coil_currents.h"
#include "service/tracker/kernel/model.h"

namespace omni::tracker {

// How far readings and currents are to be trusted. docs/theory/tracking.md (3.1), (3.2)
struct Trust {
  double model_error_relative = 2e-3;    // of the tool's field: calibration of gain, alignment, position, moment
  double coil_error_relative = 2.5e-3;   // of the coils' field: the same, and windings
  double current_error_A = 3e-3;         // of a current sensor: offset ...
  double current_error_relative = 2e-3;  // ... gain ...
  double current_step_error = 0.05;      // ... and of the largest change of a control step: inductance ...
  double current_change_error = 0.1;     // ... or, where only means are reported, of their change (lag)
  bool currents_hidden = false;          // currents are not known at all: three unknowns without a prior
  double ambient_error_T = 0;            // of a uniform field that appeared after the background was measured
  std::uint32_t sensors_out = 0;         // bit i: sensor i is not used
  double age_error_s = 2e-5;             // of a sensor's age
  double current_age_s = 3.75e-4;        // mean currents: of the ends of 4 control steps, this long before the tick's
};

// Nothing but sensor noise: for readings whose model is exact.
Trust NoiseOnly() noexcept;

using NuisanceMatrix = std::array<double, std::size_t{kNuisancesMax} * kNuisancesMax>;

// One scan, whitened: weight = diag(1/sigma) gain per sensor (zero row: that axis is not used), so that a residual is
// weight * B_model - whitened. Rates move the pose back to each sensor's own instant. docs/theory/tracking.md (3.2),
// (4.2)
template <int kCapacity>
struct BasicMeasurement {
  using Lanes = std::array<double, kCapacity>;
  int sensors = 0;
  std::array<Lanes, 9> weight{};
  std::array<Lanes, 3> whitened{};
  std::array<Lanes, 3> inverse_sigma{};  // 1/T per sensor axis; 0: not used
  Lanes age_s{};
  // Nuisances are unknowns of every scan, eliminated from the normal equations: whitened columns (row 3 n + axis), what
  // the usable axes say about them, C^T C, and S = (C^T C + prior)^-1; row-major, kNuisancesMax to a row.
  // Columns beyond the first `nuisances` are no unknowns of this scan; their sums say what it knows of them.
  int nuisances = 0, columns = 0;
  std::array<double, base::kCoilCount> current_variance_A2{};  // of this scan's currents, without the lasting part
  std::array<Lanes, std::size_t{3} * kNuisancesMax> nuisance{};
  NuisanceMatrix nuisance_information{};
  NuisanceMatrix nuisance_covariance{};
  std::array<double, 3> velocity_base_m_s{};
  std::array<double, 3> axis_rate_base_1_s{};
  double moment_scale = 1;      // of the model's moment
  double field_rms_T = 0;       // |B| of the tool, root mean square over the usable readings
  double systematic_share = 0;  // of the readings' variance: what the model gets wrong; mean over them
  int axes = 0;                 // usable readings
  int fixed = 0;                // of those, spent on unknowns without a prior
};
using Measurement = BasicMeasurement<kSensors>;            // of the base, in the tick
using ArrayMeasurement = BasicMeasurement<kArraySensors>;  // of any array, off the tick

// By component of B and sensor, T.
using LocalField = std::array<std::array<double, kSensors>, 3>;

// By reading, 8 axis + sensor.
using ReadingLanes = std::array<double, kReadings>;
inline double Dot(const ReadingLanes& a, const ReadingLanes& b) noexcept {
  double sum = 0;
  for (std::size_t row = 0; row < a.size(); ++row) sum += a[row] * b[row];
  return sum;
}
double RootMeanSquare(const ReadingLanes& values) noexcept;
using ReadingMatrix = std::array<double, std::size_t{kReadings} * kReadings>;

// A uniform field in frame B at a scan's time, and how it changes: `age_s` before, it was
//   field - age rate + age^2 / 2 acceleration
struct AmbientChange {
  std::array<double, 3> field_T{}, rate_T_s{}, acceleration_T_s2{};
};

// Known offsets in the readings.
struct Offsets {
  std::array<double, base::kCoilCount> remanence_A{}, remanence_variance_A2{};
  std::array<double, 3> ambient_base_T{}, ambient_variance_T2{};  // no variance: it is known
  AmbientChange mains;                                            // known, beside that
  const LocalField* local_base_T = nullptr;                       // known, and different at every sensor; null: none
  const ReadingLanes* reading_T = nullptr;                        // in the sensors' axes; null: none
  const ReadingLanes* reading_variance_T2 = nullptr;              // of it, not null then
};

// Subtracts coils and offsets, weighs each axis, drops what is saturated, not finite or stale. Rates are left zero.
// `now` = UpdatedHistory(scan, previous). Precondition: the model has kSensors sensors.
Measurement MakeMeasurement(const Model& model, const Trust& trust, const base::HallScan& scan,
                            const CurrentHistory& previous, const CurrentHistory& now,
                            const Offsets& offsets = {}) noexcept;

// One sensor of any array at one instant.
struct ArrayReading {
  base::Vec3 field_sensor_T;    // not finite: unusable
  unsigned saturated_axes = 0;  // bit axis
};

// The same for readings taken at rest: `readings` has model.sensors entries.
void MakeArrayMeasurement(const Model& model, const Trust& trust, const ArrayReading* readings,
                          const std::array<double, base::kCoilCount>& coil_current_A,
                          ArrayMeasurement& result) noexcept;

// What disturbs all sensors in a known shape but by an unknown amount: errors of the three currents (or the currents
// themselves; the core's remanence looks the same), and a uniform ambient field. docs/theory/tracking.md (3.2)
// Fills the nuisance fields of `result`, whose weights are set. Variance 0: left out; infinite: no prior, the shape is
// projected out of what the usable axes see. Shapes that no usable axis sees cost nothing.
template <int kCapacity>
void SetNuisances(const Model& model, const std::array<double, base::kCoilCount>& current_variance_A2,
                  const std::array<double, 3>& ambient_variance_T2, BasicMeasurement<kCapacity>& result) noexcept;

extern template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&,
                                  const std::array<double, 3>&, Measurement&) noexcept;
extern template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&,
                                  const std::array<double, 3>&, ArrayMeasurement&) noexcept;

// To a scan whose unknowns are the three currents: the columns of an ambient field. Else nothing.
void AddAmbientColumns(Measurement& result) noexcept;

}  // namespace omni::tracker
