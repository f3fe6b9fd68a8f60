// The hot kernel: model, residual and normal equations at one pose, eight sensors side by side.
// No Eigen type crosses this interface, so that the file can be built for several vector widths.
#pragma once

#include <array>

#include "service/tracker/model.h"

namespace omni::tracker {

// Where to linearise. axis, tangent_1, tangent_2 are orthonormal, right handed in the order (e1, e2, u).
struct PosePoint {
  std::array<double, 3> position_base_m{};
  std::array<double, 3> axis_base{};
  std::array<double, 3> tangent_1_base{};
  std::array<double, 3> tangent_2_base{};
};

// One scan, whitened: weight = diag(1/sigma) R_SB per sensor (zero row: that axis is not used), so that a residual is
// weight * B_model - whitened. Rates move the pose back to each sensor's own instant. docs/theory/tracking.md (4)
struct Measurement {
  std::array<SensorLanes, 9> weight{};
  std::array<SensorLanes, 3> whitened{};
  std::array<SensorLanes, 3> inverse_sigma{};  // 1/T per sensor axis; 0: not used
  SensorLanes age_s{};
  // Errors dI of the three currents are unknowns of every scan, eliminated from the normal equations: whitened columns
  // weight A (row 3 axis + coil) and (A^T W^2 A + prior)^-1, 3x3.
  std::array<SensorLanes, 9> coil{};
  std::array<double, 9> coil_covariance{};
  std::array<double, 3> velocity_base_m_s{};
  std::array<double, 3> axis_rate_base_1_s{};
  double field_rms_T = 0;  // |B| of the tool, root mean square over the usable readings
  int axes = 0;            // usable readings
};

// With the current errors at their best: for every pose, chi2 is the least over dI of |r + coil dI|^2 + prior.
struct NormalEquations {
  std::array<double, std::size_t{kParameters} * kParameters> JtJ{};  // symmetric
  std::array<double, kParameters> Jtr{};
  double chi2 = 0;
};

// Not finite where the model is not (pose inside the core or at a sensor): compare with care.
void Linearise(const Model& model, const Measurement& measurement, const PosePoint& pose,
               NormalEquations& result) noexcept;

// The tool's field (core image included) in sensor frames and its derivative with respect to the five parameters.
struct ModelField {
  std::array<double, kReadings> field_sensor_T{};
  std::array<std::array<double, kParameters>, kReadings> jacobian{};
};
void EvaluateField(const Model& model, const PosePoint& pose, ModelField& result) noexcept;

}  // namespace omni::tracker
