#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "service/peers/peer.h"

namespace omni::peers {

// The tracker eliminates the current errors by r^T (I - C S C^T) r. Peers want a residual vector, so the square root:
// with C S C^T = V diag(l) V^T (rank 3),  I - C S C^T = (I - U U^T)^2,  U = V diag(sqrt(1 - sqrt(1 - l))).
// V, l from the 3x3 problem L^T C^T C L = Q diag(l) Q^T, S = L L^T, V = C L Q diag(l)^-1/2.     tracking.md (14)
PeerScan MakePeerScan(const tracker::Measurement& measurement) {
  PeerScan scan;
  Eigen::Matrix<double, kPeerReadings, kPeerNuisances> C;
  for (std::size_t i = 0; i < tracker::kSensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t row = 3 * i + axis;
      scan.inverse_sigma[row] = measurement.inverse_sigma[axis][i];
      scan.whitened[row] = measurement.whitened[axis][i];
      for (std::size_t k = 0; k < kPeerNuisances; ++k) {
        C(static_cast<int>(row), static_cast<int>(k)) = measurement.coil[3 * axis + k][i];
      }
    }
  }
  const Eigen::Matrix3d S = Eigen::Map<const Eigen::Matrix3d>(measurement.coil_covariance.data());
  if (!(S.diagonal().minCoeff() > 0)) return scan;  // currents taken as exact
  const Eigen::Matrix3d L = S.llt().matrixL();
  const Eigen::Matrix<double, kPeerReadings, kPeerNuisances> CL = C * L;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(CL.transpose() * CL);
  for (int k = 0; k < kPeerNuisances; ++k) {
    const double l = std::clamp(eigen.eigenvalues()[k], 0.0, 1.0);
    if (!(l > 0)) continue;
    const Eigen::Matrix<double, kPeerReadings, 1> u =
        CL * eigen.eigenvectors().col(k) * std::sqrt((1 - std::sqrt(1 - l)) / l);
    for (int row = 0; row < kPeerReadings; ++row) {
      scan.nuisance_basis[static_cast<std::size_t>(kPeerNuisances * row + k)] = u[row];
    }
  }
  scan.has_nuisance = true;
  return scan;
}

}  // namespace omni::peers
