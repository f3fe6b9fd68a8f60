// Fixed-size Levenberg-Marquardt on position and direction. No allocation, bounded work.
#pragma once

#include <Eigen/Core>

#include "service/tracker/linearise.h"

namespace omni::tracker {

using Matrix5d = Eigen::Matrix<double, kParameters, kParameters>;

struct Pose {
  Eigen::Vector3d position_base_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_base = -Eigen::Vector3d::UnitZ();  // unit
};

struct Fit {
  Pose pose;
  double chi2 = 0;
  int iterations = 0;      // evaluations of the model
  bool converged = false;  // the last step was a small fraction of its own standard deviation
  // (J^T J)^-1 in (position, turn about the tangents of magnetics::MakeTangentBasis(axis)).
  Matrix5d covariance = Matrix5d::Zero();
};

// Minimises |r|^2 from `start`. damping: 0 trusts the start (warm), > 0 steps carefully at first (cold).
Fit SolvePose(const Model& model, const Measurement& measurement, const Pose& start, double damping,
              int iterations_max) noexcept;

PosePoint MakePosePoint(const Pose& pose) noexcept;

}  // namespace omni::tracker
