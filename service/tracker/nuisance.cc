#include "service/tracker/nuisance.h"

#include <cmath>

namespace omni::tracker {
namespace {

constexpr double kRidge = 1e-12;  // for shapes that the usable axes cannot tell apart

}  // namespace

// Gauss-Jordan, in units of the diagonal's roots: amperes, teslas and plain numbers stand side by side.
bool InvertSymmetric(int n, int stride, double* matrix) noexcept {
  const auto at = [matrix, stride](int r, int c) -> double& { return matrix[r * stride + c]; };
  double scale[kNuisancesMax + 1];
  for (int i = 0; i < n; ++i) {
    if (!(at(i, i) > 0 && at(i, i) <= 1e300)) return false;
    scale[i] = 1 / std::sqrt(at(i, i));
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) at(r, c) *= scale[r] * scale[c];
  }
  for (int p = 0; p < n; ++p) {
    const double pivot = at(p, p);
    if (!(pivot > 1e-14)) return false;
    const double inverse = 1 / pivot;
    at(p, p) = 1;
    for (int c = 0; c < n; ++c) at(p, c) *= inverse;
    for (int r = 0; r < n; ++r) {
      if (r == p) continue;
      const double factor = at(r, p);
      at(r, p) = 0;
      for (int c = 0; c < n; ++c) at(r, c) -= factor * at(p, c);
    }
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) at(r, c) *= scale[r] * scale[c];
  }
  return true;
}

void SetNuisancePrior(const NuisanceMatrix& covariance, Measurement& result) noexcept {
  NuisanceMatrix S = covariance;
  if (!InvertSymmetric(result.nuisances, kNuisancesMax, S.data())) return;  // the diagonal prior stays
  for (std::size_t e = 0; e < S.size(); ++e) S[e] += result.nuisance_information[e];
  if (InvertSymmetric(result.nuisances, kNuisancesMax, S.data())) result.nuisance_covariance = S;
}

template <int kCapacity>
void SetNuisances(const Model& model, const std::array<double, base::kCoilCount>& current_variance_A2,
                  double ambient_variance_T2, BasicMeasurement<kCapacity>& result) noexcept {
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
  for (std::size_t c = 0; c < 3 && ambient_variance_T2 > 0; ++c) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result.nuisance[3 * static_cast<std::size_t>(count) + axis] = result.weight[3 * axis + c];
    }
    precision[static_cast<std::size_t>(count++)] = 1 / ambient_variance_T2;
  }

  for (std::size_t a = 0; a < static_cast<std::size_t>(count); ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& of_a = result.nuisance[3 * a + axis];
        const auto& of_b = result.nuisance[3 * b + axis];
        for (std::size_t i = 0; i < sensors; ++i) sum += of_a[i] * of_b[i];
      }
      result.nuisance_information[a * kNuisancesMax + b] = sum;
      result.nuisance_information[b * kNuisancesMax + a] = sum;
    }
  }
  auto& S = result.nuisance_covariance;
  S = result.nuisance_information;
  for (std::size_t a = 0; a < static_cast<std::size_t>(count); ++a) {
    double& information = S[a * kNuisancesMax + a];
    if (precision[a] == 0 && information > 0) ++result.fixed;
    information = information * (1 + kRidge) + precision[a];
    if (information == 0) information = 1;  // unseen and without a prior: any value does
  }
  if (!InvertSymmetric(count, kNuisancesMax, S.data())) result.axes = 0;  // not finite: nothing is usable
  result.nuisances = count;
}

template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&, double, Measurement&) noexcept;
template void SetNuisances(const Model&, const std::array<double, base::kCoilCount>&, double,
                           ArrayMeasurement&) noexcept;

}  // namespace omni::tracker
