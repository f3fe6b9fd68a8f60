#include "service/tracker/kernel/linearise.h"

#include <algorithm>
#include <type_traits>

namespace omni::tracker {
namespace {

template <class Real, class Source>
void Copy(const Source& source, std::size_t first, Real (&lanes)[kBlockSensors]) noexcept {
  for (std::size_t i = 0; i < kBlockSensors; ++i) lanes[i] = static_cast<Real>(source[first + i]);
}

// The moment's scale multiplies every order.
template <class Real>
void Scale(Real factor, ToolSource<Real>& tool) noexcept {
  if (factor == 1) return;
  for (Real& q : tool.zonal) q *= factor;
}

}  // namespace

template <class Real, int kCapacity>
void PackProblem(const Model& model, const BasicMeasurement<kCapacity>& measurement,
                 Problem<Real, kCapacity>& problem) noexcept {
  if constexpr (std::is_same_v<Real, float>) {
    problem.tool = model.tool_float;
    problem.places = model.places_float.data();
  } else {
    problem.tool = model.tool;
    problem.places = model.places.data();
  }
  Scale(static_cast<Real>(measurement.moment_scale), problem.tool);
  problem.block_count = (measurement.sensors + kBlockSensors - 1) / kBlockSensors;
  for (int b = 0; b < problem.block_count; ++b) {
    SensorBlock<Real>& block = problem.blocks[b];
    const std::size_t first = static_cast<std::size_t>(b) * kBlockSensors;
    for (std::size_t row = 0; row < 3; ++row) {
      Copy(measurement.whitened[row], first, block.whitened[row]);
    }
    for (std::size_t row = 0; row < 9; ++row) Copy(measurement.weight[row], first, block.weight[row]);
    Copy(measurement.age_s, first, block.age_s);
    for (std::size_t row = 0; row < 3 * static_cast<std::size_t>(measurement.columns); ++row) {
      Copy(measurement.nuisance[row], first, block.nuisance[row]);
    }
  }
}

template void PackProblem(const Model&, const Measurement&, Problem<float, kSensors>&) noexcept;
template void PackProblem(const Model&, const Measurement&, Problem<double, kSensors>&) noexcept;
template void PackProblem(const Model&, const ArrayMeasurement&, Problem<float, kArraySensors>&) noexcept;
template void PackProblem(const Model&, const ArrayMeasurement&, Problem<double, kArraySensors>&) noexcept;

KernelPose ToKernel(const PosePoint& pose, const std::array<double, 3>& velocity_base_m_s,
                    const std::array<double, 3>& axis_rate_base_1_s) noexcept {
  KernelPose at{};
  for (std::size_t i = 0; i < 3; ++i) {
    at.position_base_m[i] = pose.position_base_m[i];
    at.axis_base[i] = pose.axis_base[i];
    at.tangent_1_base[i] = pose.tangent_1_base[i];
    at.tangent_2_base[i] = pose.tangent_2_base[i];
    at.rate_1_s[i] = velocity_base_m_s[i];
    at.rate_1_s[3] += axis_rate_base_1_s[i] * pose.tangent_1_base[i];
    at.rate_1_s[4] += axis_rate_base_1_s[i] * pose.tangent_2_base[i];
  }
  return at;
}

// Schur complement of the nuisances, S = (C^T C + diag(1/s^2))^-1:
//   JtJ - (C^T J)^T S (C^T J),   Jtr - (C^T J)^T S C^T r,   rtr - (C^T r)^T S C^T r
// which is the same as whitening with diag(sigma^2) + sum_j s_j^2 a_j a_j^T.
void EliminateNuisances(const KernelTask& task, const KernelSums& sums,
                        const std::array<double, std::size_t{kNuisancesMax} * kNuisancesMax>& S,
                        NormalEquations& result) noexcept {
  const auto count = static_cast<std::size_t>(task.parameters);
  const auto nuisances = static_cast<std::size_t>(task.nuisances);
  result.chi2 = sums.rtr;
  for (std::size_t k = 0, e = 0; k < count; ++k) {
    result.Jtr[k] = sums.Jtr[k];
    for (std::size_t j = 0; j <= k; ++j) {
      result.JtJ[kParameters * k + j] = result.JtJ[kParameters * j + k] = sums.JtJ[e++];
    }
  }
  if (task.moment) {
    result.MtM = sums.MtM;
    result.Mtr = sums.Mtr;
    std::copy_n(sums.MtJ, count, result.MtJ.begin());
  }
  for (std::size_t a = 0; a < nuisances; ++a) {
    double S_Ctr = 0, S_CtM = 0;
    std::array<double, kParameters> S_CtJ{};
    for (std::size_t b = 0; b < nuisances; ++b) {
      const double s = S[a * kNuisancesMax + b];
      S_Ctr += s * sums.Ctr[b];
      if (task.moment) S_CtM += s * sums.CtM[b];
      for (std::size_t k = 0; k < count; ++k) S_CtJ[k] += s * sums.CtJ[b][k];
    }
    result.chi2 -= sums.Ctr[a] * S_Ctr;
    for (std::size_t k = 0; k < count; ++k) {
      result.Jtr[k] -= S_CtJ[k] * sums.Ctr[a];
      for (std::size_t j = 0; j < count; ++j) result.JtJ[kParameters * k + j] -= sums.CtJ[a][k] * S_CtJ[j];
    }
    if (!task.moment) continue;
    result.MtM -= sums.CtM[a] * S_CtM;
    result.Mtr -= sums.CtM[a] * S_Ctr;
    for (std::size_t k = 0; k < count; ++k) result.MtJ[k] -= S_CtJ[k] * sums.CtM[a];
  }
}

template <int kCapacity>
void Linearise(const Model& model, const BasicMeasurement<kCapacity>& measurement, const PosePoint& pose,
               NormalEquations& result) noexcept {
  Problem<double, kCapacity> problem;
  PackProblem(model, measurement, problem);
  const KernelTask task{kParameters, measurement.nuisances, true};
  KernelSums sums;
  ActiveKernel().in_double.sum(problem.places, problem.blocks, problem.block_count, problem.tool,
                               ToKernel(pose, measurement.velocity_base_m_s, measurement.axis_rate_base_1_s), task,
                               nullptr, sums);
  EliminateNuisances(task, sums, measurement.nuisance_covariance, result);
}
template void Linearise(const Model&, const Measurement&, const PosePoint&, NormalEquations&) noexcept;
template void Linearise(const Model&, const ArrayMeasurement&, const PosePoint&, NormalEquations&) noexcept;

void EvaluateField(const Model& model, const PosePoint& pose, std::span<double> field_sensor_T,
                   std::span<std::array<double, kParameters>> jacobian) noexcept {
  const KernelPose at = ToKernel(pose, {}, {});
  for (int first = 0; first < model.sensors; first += kBlockSensors) {
    BlockField field;
    ActiveKernel().field(model.places[static_cast<std::size_t>(first / kBlockSensors)], model.tool, at, field);
    for (int lane = 0; lane < kBlockSensors && first + lane < model.sensors; ++lane) {
      const std::size_t i = static_cast<std::size_t>(first) + static_cast<std::size_t>(lane);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto in_sensor = [&](const double(&B)[3][kBlockSensors]) {
          return model.gain_sensor_base[3 * axis][i] * B[0][lane] +
                 model.gain_sensor_base[3 * axis + 1][i] * B[1][lane] +
                 model.gain_sensor_base[3 * axis + 2][i] * B[2][lane];
        };
        field_sensor_T[3 * i + axis] = in_sensor(field.B_T);
        for (std::size_t k = 0; k < kParameters; ++k) jacobian[3 * i + axis][k] = in_sensor(field.derivative[k]);
      }
    }
  }
}

void EvaluateField(const Model& model, const PosePoint& pose, ModelField& result) noexcept {
  EvaluateField(model, pose, result.field_sensor_T, result.jacobian);
}

}  // namespace omni::tracker
