#include "service/actuation/box_least_squares.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace omni::actuation {
namespace {

constexpr double kRegular = 1e-6;  // of the metric's trace
constexpr double kSlack = 1e-12;   // relative: a minimum that lies on an edge belongs to both faces

// The six entries as a matrix; d = I - I0.
struct Problem {
  double H[3][3];
  double centre[3];  // I0
  double limit[3];

  double Cost(const double* d) const noexcept {
    double cost = 0;
    for (int i = 0; i < 3; ++i) cost += d[i] * (H[i][0] * d[0] + H[i][1] * d[1] + H[i][2] * d[2]);
    return cost;
  }
  bool Inside(int k, double d) const noexcept { return std::abs(centre[k] + d) <= limit[k] * (1 + kSlack); }
};

struct Best {
  double cost = std::numeric_limits<double>::infinity();
  double d[3] = {};

  void Offer(const Problem& problem, const double* candidate) noexcept {
    const double offered = problem.Cost(candidate);
    if (!(offered < cost)) return;
    cost = offered;
    for (int k = 0; k < 3; ++k) d[k] = candidate[k];
  }
};

// Corner, then the three edges that start there towards the opposite side of one coordinate are visited once each, by
// the corners where that coordinate is at its lower limit.
void TryCornersAndEdges(const Problem& problem, Best& best) noexcept {
  for (int corner = 0; corner < 8; ++corner) {
    double d[3];
    for (int k = 0; k < 3; ++k) {
      d[k] = ((corner >> k) & 1 ? problem.limit[k] : -problem.limit[k]) - problem.centre[k];
    }
    best.Offer(problem, d);
    for (int k = 0; k < 3; ++k) {
      if ((corner >> k) & 1) continue;
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      // dCost/dd_k = 0
      const double along = -(problem.H[k][i] * d[i] + problem.H[k][j] * d[j]) / problem.H[k][k];
      if (!problem.Inside(k, along)) continue;
      double edge[3] = {d[0], d[1], d[2]};
      edge[k] = along;
      best.Offer(problem, edge);
    }
  }
}

// Coordinate k at a limit, the other two free: H_ff d_f = -H_fk d_k.
void TryFaces(const Problem& problem, Best& best) noexcept {
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double determinant = problem.H[i][i] * problem.H[j][j] - problem.H[i][j] * problem.H[i][j];
    const double slope_i = (problem.H[i][j] * problem.H[j][k] - problem.H[j][j] * problem.H[i][k]) / determinant;
    const double slope_j = (problem.H[i][j] * problem.H[i][k] - problem.H[i][i] * problem.H[j][k]) / determinant;
    for (const double side : {-1.0, 1.0}) {
      double face[3];
      face[k] = side * problem.limit[k] - problem.centre[k];
      face[i] = slope_i * face[k];
      face[j] = slope_j * face[k];
      if (problem.Inside(i, face[i]) && problem.Inside(j, face[j])) best.Offer(problem, face);
    }
  }
}

}  // namespace

// G = X^T W^2 X, W^2 = w^2 I + (1 - w^2) f f^T / |f|^2
CurrentMetric MakeCurrentMetric(const std::array<double, 9>& newton_per_ampere, const base::Vec3& force_N,
                                double direction_weight) noexcept {
  const double* X = newton_per_ampere.data();
  const double square_N2 = force_N.x * force_N.x + force_N.y * force_N.y + force_N.z * force_N.z;
  const double across = square_N2 > 0 ? direction_weight * direction_weight : 1.0;
  const double along = square_N2 > 0 ? (1 - across) / square_N2 : 0.0;
  double fX[3];
  for (int k = 0; k < 3; ++k) fX[k] = force_N.x * X[k] + force_N.y * X[3 + k] + force_N.z * X[6 + k];
  const auto entry = [&](int i, int j) {
    return across * (X[i] * X[j] + X[3 + i] * X[3 + j] + X[6 + i] * X[6 + j]) + along * fX[i] * fX[j];
  };
  CurrentMetric H{entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
  const double regular = kRegular * (H.xx + H.yy + H.zz);
  H.xx += regular;
  H.yy += regular;
  H.zz += regular;
  return H;
}

CurrentArray NearestInBox(const CurrentMetric& H, const CurrentArray& wanted_A, const CurrentArray& max_A) noexcept {
  Problem problem{.H = {{H.xx, H.xy, H.xz}, {H.xy, H.yy, H.yz}, {H.xz, H.yz, H.zz}},
                  .centre = {wanted_A[0], wanted_A[1], wanted_A[2]},
                  .limit = {max_A[0], max_A[1], max_A[2]}};
  if (problem.Inside(0, 0) && problem.Inside(1, 0) && problem.Inside(2, 0)) return wanted_A;
  Best best;
  TryCornersAndEdges(problem, best);
  TryFaces(problem, best);
  CurrentArray nearest{};
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    const double current_A = problem.centre[k] + best.d[k];
    nearest[k] = std::fmin(std::fmax(current_A, -max_A[k]), max_A[k]);  // rounding
  }
  return nearest;
}

}  // namespace omni::actuation
