#include "service/tracker/cold_start.h"

#include <Eigen/LU>
#include <algorithm>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

struct Score {
  double explained = -1;  // part of |y|^2 that the best moment at this point explains
  std::size_t grid = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
};

// Variable projection [Golub & Pereyra 1973]: at a fixed place the model is linear in the moment, y = G m.
// explained = b^T N^-1 b with N = G^T W^2 G, b = G^T W^2 y; unused axes have weight zero.
Score ScoreGridPoint(const Model& model, const Measurement& measurement, std::size_t grid) noexcept {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  const auto& G = model.grid_field_sensor[grid];
  for (std::size_t i = 0; i < kSensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double w = measurement.inverse_sigma[axis][i];
      const Eigen::Vector3d row = w * Eigen::Map<const Eigen::Vector3d>(&G[(3 * i + axis) * 3]);
      N += row * row.transpose();
      b += row * measurement.whitened[axis][i];
    }
  }
  const Eigen::Vector3d m = N.inverse() * b;
  return {.explained = b.dot(m), .grid = grid, .moment = m};
}

}  // namespace

ColdCandidates RankGrid(const Model& model, const Measurement& measurement) noexcept {
  std::array<Score, kGridPoints> scores;
  for (std::size_t g = 0; g < scores.size(); ++g) {
    scores[g] = ScoreGridPoint(model, measurement, g);
    if (!(scores[g].explained >= 0 && scores[g].moment.norm() > 0)) scores[g].explained = -1;  // NaN included
  }
  std::partial_sort(scores.begin(), scores.begin() + kColdCandidates, scores.end(),
                    [](const Score& a, const Score& b) { return a.explained > b.explained; });
  ColdCandidates result;
  for (std::size_t c = 0; c < kColdCandidates && scores[c].explained >= 0; ++c) {
    result.poses[c] = {base::ToEigen(model.grid_base_m[scores[c].grid]), scores[c].moment.normalized()};
    ++result.count;
  }
  return result;
}

}  // namespace omni::tracker
