// The rotation nearest to a deformation, warm-started from the last one; for the peers.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace omni::bench {

// [Mueller, Bender, Chentanez & Macklin 2016]
inline void ExtractRotation(const Eigen::Matrix3d& f, Eigen::Quaterniond& q) {
  for (int k = 0; k < 4; ++k) {
    const Eigen::Matrix3d r = q.toRotationMatrix();
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();
    double down = 1e-9;
    for (int c = 0; c < 3; ++c) {
      omega += r.col(c).cross(f.col(c));
      down += r.col(c).dot(f.col(c));
    }
    omega /= std::abs(down);
    const double angle = omega.norm();
    if (angle < 1e-9) return;
    q = Eigen::Quaterniond(Eigen::AngleAxisd(angle, omega / angle)) * q;
    q.normalize();
  }
}

}  // namespace omni::bench
