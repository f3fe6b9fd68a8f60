// Numbers for property tests: seeded directions, central differences, relative errors.
#pragma once

#include <Eigen/Core>
#include <random>

namespace omni::support {

using Rng = std::mt19937_64;

inline double Uniform(Rng& rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(rng);
}

inline Eigen::Vector3d RandomUnit(Rng& rng) {
  std::normal_distribution<double> normal;
  for (;;) {
    const Eigen::Vector3d v(normal(rng), normal(rng), normal(rng));
    if (v.norm() > 1e-3) return v.normalized();
  }
}

// Jacobian of f: R^3 -> R^3 at x by fourth-order central differences.
template <class F>
Eigen::Matrix3d NumericJacobian(const F& f, const Eigen::Vector3d& x, double h) {
  Eigen::Matrix3d J;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d e = h * Eigen::Vector3d::Unit(k);
    const Eigen::Vector3d near = f(Eigen::Vector3d(x + e)) - f(Eigen::Vector3d(x - e));
    const Eigen::Vector3d far = f(Eigen::Vector3d(x + 2 * e)) - f(Eigen::Vector3d(x - 2 * e));
    J.col(k) = (8 * near - far) / (12 * h);
  }
  return J;
}

template <class A, class B>
double RelativeError(const A& value, const B& reference) {
  return (value - reference).norm() / reference.norm();
}

}  // namespace omni::support
