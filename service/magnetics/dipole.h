// Point sources: dipole and magnetic charge, each with its gradient. Valid everywhere but at the source (d = 0).
// Conventions of this module: d = observation - source (m), fields in tesla, moments in A m^2, charges in A m.
// A gradient G is dB/dd: B(d + e) = B(d) + G e. Outside sources div B = curl B = 0, so G is symmetric and traceless.
#pragma once

#include <Eigen/Core>
#include <numbers>

namespace omni::magnetics {

inline constexpr double kMu0 = 4e-7 * std::numbers::pi;
inline constexpr double kMu0Over4Pi = 1e-7;

// docs/theory/magnetics.md (1)
Eigen::Vector3d DipoleField(const Eigen::Vector3d& m, const Eigen::Vector3d& d) noexcept;

// The matrix D(d) with DipoleField(m, d) = D(d) m. Symmetric: the reciprocity of two dipoles.
Eigen::Matrix3d DipoleMatrix(const Eigen::Vector3d& d) noexcept;

// docs/theory/magnetics.md (2)
Eigen::Matrix3d DipoleGradient(const Eigen::Vector3d& m, const Eigen::Vector3d& d) noexcept;

// docs/theory/magnetics.md (3)
Eigen::Vector3d ChargeField(double q, const Eigen::Vector3d& d) noexcept;
Eigen::Matrix3d ChargeGradient(double q, const Eigen::Vector3d& d) noexcept;

}  // namespace omni::magnetics
