// Normal equations at one pose, with everything that disturbs the readings eliminated; and the model's field itself.
#pragma once

#include <array>
#include <span>

#include "service/tracker/kernel/kernel.h"
#include "service/tracker/kernel/measurement.h"
#include "service/tracker/kernel/model.h"

namespace omni::tracker {

// Where to linearise. axis, tangent_1, tangent_2 are orthonormal, right handed in the order (e1, e2, u).
struct PosePoint {
  std::array<double, 3> position_base_m{};
  std::array<double, 3> axis_base{};
  std::array<double, 3> tangent_1_base{};
  std::array<double, 3> tangent_2_base{};
};

// Model and measurement of one scan packed for the kernel, in either precision.
template <class Real, int kCapacity>
struct Problem {
  const SensorPlaces<Real>* places = nullptr;  // of the model
  SensorBlock<Real> blocks[kCapacity / kBlockSensors];
  int block_count = 0;
  ToolSource<Real> tool;
};

template <class Real, int kCapacity>
void PackProblem(const Model& model, const BasicMeasurement<kCapacity>& measurement,
                 Problem<Real, kCapacity>& problem) noexcept;

extern template void PackProblem(const Model&, const Measurement&, Problem<float, kSensors>&) noexcept;
extern template void PackProblem(const Model&, const Measurement&, Problem<double, kSensors>&) noexcept;
extern template void PackProblem(const Model&, const ArrayMeasurement&, Problem<float, kArraySensors>&) noexcept;
extern template void PackProblem(const Model&, const ArrayMeasurement&, Problem<double, kArraySensors>&) noexcept;

// With the nuisances at their best: for every pose, chi2 is the least over them of |r + C n|^2 + prior.
// Entries that the task leaves out are not written, nor cleared: that would cost as much as the sums are worth.
struct NormalEquations {
  std::array<double, std::size_t{kParameters} * kParameters> JtJ;  // symmetric
  std::array<double, kParameters> Jtr;
  double chi2;
  // Column of a relative change of the tool's moment.
  std::array<double, kParameters> MtJ;
  double MtM, Mtr;
};

KernelPose ToKernel(const PosePoint& pose, const std::array<double, 3>& velocity_base_m_s,
                    const std::array<double, 3>& axis_rate_base_1_s) noexcept;

// S: BasicMeasurement::nuisance_covariance. docs/theory/tracking.md (3.2)
void EliminateNuisances(const KernelTask& task, const KernelSums& sums,
                        const std::array<double, std::size_t{kNuisancesMax} * kNuisancesMax>& S,
                        NormalEquations& result) noexcept;

// Not finite where the model is not (pose inside the core or at a sensor): compare with care.
template <int kCapacity>
void Linearise(const Model& model, const BasicMeasurement<kCapacity>& measurement, const PosePoint& pose,
               NormalEquations& result) noexcept;
extern template void Linearise(const Model&, const Measurement&, const PosePoint&, NormalEquations&) noexcept;
extern template void Linearise(const Model&, const ArrayMeasurement&, const PosePoint&, NormalEquations&) noexcept;

// The tool's field (core image included) in sensor frames and its derivative with respect to the five parameters;
// reading 3 i + axis. Both spans hold 3 * model.sensors entries.
void EvaluateField(const Model& model, const PosePoint& pose, std::span<double> field_sensor_T,
                   std::span<std::array<double, kParameters>> jacobian) noexcept;

// The same for the base's own sensors.
struct ModelField {
  std::array<double, kReadings> field_sensor_T{};
  std::array<std::array<double, kParameters>, kReadings> jacobian{};
};
void EvaluateField(const Model& model, const PosePoint& pose, ModelField& result) noexcept;

}  // namespace omni::tracker
