#include "service/magnetics/dipole.h"

#include <cmath>

namespace omni::magnetics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// B = mu0/4pi (3 (m.n) n - m) / r^3, n = d/r   [Jackson 3e, 5.56]
Vector3d DipoleField(const Vector3d& m, const Vector3d& d) noexcept {
  const double r2 = d.squaredNorm();
  return (kMu0Over4Pi / (r2 * std::sqrt(r2))) * ((3 * m.dot(d) / r2) * d - m);
}

Matrix3d DipoleMatrix(const Vector3d& d) noexcept {
  const double r2 = d.squaredNorm();
  return (kMu0Over4Pi / (r2 * std::sqrt(r2))) * ((3 / r2) * d * d.transpose() - Matrix3d::Identity());
}

// G = 3 mu0/4pi / r^5 ((m.d) I + m d^T + d m^T - 5 (m.d) d d^T / r^2)   [derivative of Jackson 3e, 5.56]
Matrix3d DipoleGradient(const Vector3d& m, const Vector3d& d) noexcept {
  const double r2 = d.squaredNorm();
  const double md = m.dot(d);
  const Matrix3d md_T = m * d.transpose();
  return (3 * kMu0Over4Pi / (r2 * r2 * std::sqrt(r2))) *
         (md * Matrix3d::Identity() + md_T + md_T.transpose() - (5 * md / r2) * d * d.transpose());
}

// B = mu0/4pi q d / r^3   [Jackson 3e, 5.9 C: magnetic charge]
Vector3d ChargeField(double q, const Vector3d& d) noexcept {
  const double r2 = d.squaredNorm();
  return (kMu0Over4Pi * q / (r2 * std::sqrt(r2))) * d;
}

Matrix3d ChargeGradient(double q, const Vector3d& d) noexcept {
  const double r2 = d.squaredNorm();
  return (kMu0Over4Pi * q / (r2 * std::sqrt(r2))) * (Matrix3d::Identity() - (3 / r2) * d * d.transpose());
}

}  // namespace omni::magnetics
