// Point sets onto each other in closed form: the textbook answer that the product's fit is compared with.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "service/alignment/rigid.h"
#include "service/base/eigen.h"

namespace omni::alignment {

struct PointPair {
  base::Vec3 base_m;   // p_B
  base::Vec3 space_m;  // p_L
  double weight = 1;   // > 0
};

struct Means {
  Eigen::Vector3d base = Eigen::Vector3d::Zero(), space = Eigen::Vector3d::Zero();
};

inline Means WeightedMeans(const std::vector<PointPair>& pairs) {
  Means means;
  double sum = 0;
  for (const PointPair& pair : pairs) {
    means.base += pair.weight * base::ToEigen(pair.base_m);
    means.space += pair.weight * base::ToEigen(pair.space_m);
    sum += pair.weight;
  }
  if (sum > 0) {
    means.base /= sum;
    means.space /= sum;
  }
  return means;
}

inline Rigid Place(const Eigen::Matrix3d& R_LB, const Means& means) {
  return {.orientation = base::FromEigen(Eigen::Quaterniond(R_LB).normalized()),
          .position_m = base::FromEigen(Eigen::Vector3d(means.space - R_LB * means.base))};
}

// X_LB that minimises sum w |p_L - X_LB p_B|^2, a rotation in any case (never a reflection). Three pairs that are not
// on a line, at least: else the rotation is one of many.   [Kabsch 1976, Umeyama 1991; docs/theory/alignment.md (1)]
inline Rigid FitSixDof(const std::vector<PointPair>& pairs) {
  const Means means = WeightedMeans(pairs);
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    H += pair.weight * (base::ToEigen(pair.base_m) - means.base) *
         (base::ToEigen(pair.space_m) - means.space).transpose();
  }
  // H = U S V^T;  R = V diag(1, 1, det(V U^T)) U^T
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d guard(1, 1, 1);
  if ((svd.matrixV() * svd.matrixU().transpose()).determinant() < 0) guard.z() = -1;
  return Place(svd.matrixV() * guard.asDiagonal() * svd.matrixU().transpose(), means);
}

// The same with gravity known in both: B's z is L's y, only yaw and place are free. Two pairs that are not one above
// the other, at least.   [docs/theory/alignment.md (2)]
inline Rigid FitFourDof(const std::vector<PointPair>& pairs) {
  const Means means = WeightedMeans(pairs);
  const Eigen::Matrix3d R_level = base::ToEigen(LevelBase().orientation).toRotationMatrix();
  double sine = 0, cosine = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d a = R_level * (base::ToEigen(pair.base_m) - means.base);
    const Eigen::Vector3d b = base::ToEigen(pair.space_m) - means.space;
    cosine += pair.weight * (b.x() * a.x() + b.z() * a.z());
    sine += pair.weight * (b.x() * a.z() - b.z() * a.x());
  }
  const double yaw = sine == 0 && cosine == 0 ? 0 : std::atan2(sine, cosine);
  return Place(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY()).toRotationMatrix() * R_level, means);
}

}  // namespace omni::alignment
