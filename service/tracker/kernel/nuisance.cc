#include "service/tracker/kernel/measurement.h"

#include "service/tracker/kernel/cholesky.h"

namespace omni::tracker {
namespace {

constexpr double kRidge = 1e-12;  // for shapes that the usable axes cannot distinguish

template <int kCapacity>
void PutAmbientColumns(BasicMeasurement<kCapacity>& result) noexcept {
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result.nuisance[3 * static_cast<std::size_t>(result.columns) + axis] = result.weight[3 * axis + c];
    }
    ++result.columns;
  }
}

// C^T C from column `first` on.
template <int kCapacity>
void AddInformation(int first, BasicMeasurement<kCapacity>& result) noexcept {
  const int blocks = (result.sensors + kBlockSensors - 1) / kBlockSensors;
  const std::size_t lanes = static_cast<std::size_t>(blocks) * kBlockSensors;
  for (auto a = static_cast<std::size_t>(first); a < static_cast<std::size_t>(result.columns); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      std::array<double, kBlockSensors> sums{};  // of every eighth sensor
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double* of_a = result.nuisance[3 * a + axis].data();
        const double* of_b = result.nuisance[3 * b + axis].data();
        for (std::size_t i = 0; i < lanes; i += kBlockSensors) {
          for (std::size_t lane = 0; lane < kBlockSensors; ++lane) sums[lane] += of_a[i + lane] * of_b[i + lane];
        }
      }
      double sum = 0;
      for (const double of_lane : sums) sum += of_lane;
      result.nuisance_information[a * kNuisancesMax + b] = sum;
      result.nuisance_information[b * kNuisancesMax + a] = sum;
    }
  }
}

// The leading `count` rows and columns.
bool InvertLeading(int count, NuisanceMatrix& S) noexcept {
  static_assert(kNuisancesMax == 6);
  switch (count) {
    case 0:
      return true;
    case 1:
      return InvertPositive<1>(S.data(), kNuisancesMax);
    case 2:
      return InvertPositive<2>(S.data(), kNuisancesMax);
    case 3:
      return InvertPositive<3>(S.data(), kNuisancesMax);
    case 4:
      return InvertPositive<4>(S.data(), kNuisancesMax);
    case 5:
      return InvertPositive<5>(S.data(), kNuisancesMax);
    default:
      return InvertPositive<6>(S.data(), kNuisancesMax);
  }
}

}  // namespace

template <int kCapacity>
void SetNuisances(const Model& model, const std::array<double, base::kCoilCount>& current_variance_A2,
                  const std::array<double, 3>& ambient_variance_T2, BasicMeasurement<kCapacity>& result) noexcept {
  const auto sensors = static_cast<std::size_t>(result.sensors);
  std::array<double, kNuisancesMax> precision{};
  int count = 0;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    if (!(current_variance_A2[k] > 0)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto& column = result.nuisance[3 * static_cast<std::size_t>(count) + axis];
      for (std::size_t i = 0; i < sensors; ++i) {
        column[i] = result.inverse_sigma[axis][i] * model.coil_map_T_A[(3 * i + axis) * base::kCoilCount + k];
      }
    }
    precision[static_cast<std::size_t>(count++)] = 1 / current_variance_A2[k];
  }
  result.columns = count;
  if (ambient_variance_T2[0] > 0 && ambient_variance_T2[1] > 0 && ambient_variance_T2[2] > 0) {
    PutAmbientColumns(result);
    for (const double variance : ambient_variance_T2) precision[static_cast<std::size_t>(count++)] = 1 / variance;
  }
  AddInformation(0, result);
  auto& S = result.nuisance_covariance;
  S = result.nuisance_information;
  for (std::size_t a = 0; a < static_cast<std::size_t>(count); ++a) {
    double& information = S[a * kNuisancesMax + a];
    if (precision[a] == 0 && information > 0) ++result.fixed;
    information = information * (1 + kRidge) + precision[a];
    if (information == 0) information = 1;  // unseen and without a prior: any value does
  }
  if (!InvertLeading(count, S)) result.axes = 0;  // not finite: nothing is usable
  result.nuisances = count;
}

void AddAmbientColumns(Measurement& result) noexcept {
  if (result.nuisances != base::kCoilCount || result.columns != result.nuisances) return;  // none, or there already
  PutAmbientColumns(result);
  AddInformation(base::kCoilCount, result);
}

template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&, const std::array<double, 3>&,
                           Measurement&) noexcept;
template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&, const std::array<double, 3>&,
                           ArrayMeasurement&) noexcept;

}  // namespace omni::tracker
