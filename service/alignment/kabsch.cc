#include "service/alignment/kabsch.h"

#include <cmath>

#include <Eigen/Dense>

#include "service/base/eigen.h"

namespace omni::alignment {
namespace {

using base::FromEigen;
using base::ToEigen;
using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Means {
  Vector3d base = Vector3d::Zero(), space = Vector3d::Zero();
};

Means WeightedMeans(const std::vector<PointPair>& pairs) {
  Means means;
  double sum = 0;
  for (const PointPair& pair : pairs) {
    means.base += pair.weight * ToEigen(pair.base_m);
    means.space += pair.weight * ToEigen(pair.space_m);
    sum += pair.weight;
  }
  if (sum > 0) {
    means.base /= sum;
    means.space /= sum;
  }
  return means;
}

Rigid Place(const Matrix3d& R_LB, const Means& means) {
  return {.orientation = FromEigen(Eigen::Quaterniond(R_LB).normalized()),
          .position_m = FromEigen(Vector3d(means.space - R_LB * means.base))};
}

}  // namespace

Rigid LevelBase() {
  const double h = std::sqrt(0.5);  // -90 degrees about x: B's z -> L's y, B's y -> L's -z
  return {.orientation = {h, -h, 0, 0}, .position_m = {}};
}

Rigid FitSixDof(const std::vector<PointPair>& pairs) {
  const Means means = WeightedMeans(pairs);
  Matrix3d H = Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    H += pair.weight * (ToEigen(pair.base_m) - means.base) * (ToEigen(pair.space_m) - means.space).transpose();
  }
  // H = U S V^T;  R = V diag(1, 1, det(V U^T)) U^T
  const Eigen::JacobiSVD<Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d guard(1, 1, 1);
  if ((svd.matrixV() * svd.matrixU().transpose()).determinant() < 0) guard.z() = -1;
  return Place(svd.matrixV() * guard.asDiagonal() * svd.matrixU().transpose(), means);
}

Rigid FitFourDof(const std::vector<PointPair>& pairs) {
  const Means means = WeightedMeans(pairs);
  const Matrix3d R_level = ToEigen(LevelBase().orientation).toRotationMatrix();
  double sine = 0, cosine = 0;
  for (const PointPair& pair : pairs) {
    const Vector3d a = R_level * (ToEigen(pair.base_m) - means.base);
    const Vector3d b = ToEigen(pair.space_m) - means.space;
    cosine += pair.weight * (b.x() * a.x() + b.z() * a.z());
    sine += pair.weight * (b.x() * a.z() - b.z() * a.x());
  }
  const double yaw = sine == 0 && cosine == 0 ? 0 : std::atan2(sine, cosine);
  return Place(Eigen::AngleAxisd(yaw, Vector3d::UnitY()).toRotationMatrix() * R_level, means);
}

}  // namespace omni::alignment
