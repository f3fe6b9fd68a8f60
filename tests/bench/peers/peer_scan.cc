#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tests/bench/peers/peer.h"

namespace omni::peers {

// The tracker eliminates its nuisances by r^T (I - C S C^T) r. Peers need a residual vector, so the square root: with C
// S C^T = V diag(l) V^T,  I - C S C^T = (I - U U^T)^2,  U = V diag(sqrt(1 - sqrt(1 - l))). V and l from the small
// problem L^T C^T C L = Q diag(l) Q^T,  S = L L^T,  V = C L Q diag(l)^-1/2.
PeerScan MakePeerScan(const tracker::Measurement& measurement) {
  PeerScan scan;
  const int count = measurement.nuisances;
  Eigen::MatrixXd C(kPeerReadings, count);
  for (std::size_t i = 0; i < tracker::kSensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t row = 3 * i + axis;
      scan.inverse_sigma[row] = measurement.inverse_sigma[axis][i];
      scan.whitened[row] = measurement.whitened[axis][i];
      for (int n = 0; n < count; ++n) {
        C(static_cast<int>(row), n) = measurement.nuisance[static_cast<std::size_t>(3 * n) + axis][i];
      }
    }
  }
  if (count == 0) return scan;
  using Square = Eigen::Matrix<double, kPeerNuisances, kPeerNuisances, Eigen::RowMajor>;
  const Eigen::MatrixXd S =
      Eigen::Map<const Square>(measurement.nuisance_covariance.data()).topLeftCorner(count, count);
  const Eigen::MatrixXd CL = C * Eigen::MatrixXd(S.llt().matrixL());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(CL.transpose() * CL);
  for (int k = 0; k < count; ++k) {
    const double l = std::clamp(eigen.eigenvalues()[k], 0.0, 1.0);
    if (!(l > 0)) continue;
    const Eigen::VectorXd u = CL * eigen.eigenvectors().col(k) * std::sqrt((1 - std::sqrt(1 - l)) / l);
    for (std::size_t row = 0; row < kPeerReadings; ++row) {
      scan.nuisance_basis[kPeerNuisances * row + scan.nuisances] = u[static_cast<Eigen::Index>(row)];
    }
    ++scan.nuisances;
  }
  return scan;
}

}  // namespace omni::peers
