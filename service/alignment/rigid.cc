#include "service/alignment/rigid.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

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

Rigid Compose(const Rigid& X_AB, const Rigid& X_BC) {
  const Eigen::Quaterniond q_AB = ToEigen(X_AB.orientation);
  return {.orientation = FromEigen((q_AB * ToEigen(X_BC.orientation)).normalized()),
          .position_m = FromEigen(Eigen::Vector3d(ToEigen(X_AB.position_m) + q_AB * ToEigen(X_BC.position_m)))};
}

Rigid Inverse(const Rigid& X_AB) {
  const Eigen::Quaterniond q_BA = ToEigen(X_AB.orientation).normalized().conjugate();
  return {.orientation = FromEigen(q_BA), .position_m = FromEigen(Eigen::Vector3d(-(q_BA * ToEigen(X_AB.position_m))))};
}

base::Vec3 TransformPoint(const Rigid& X_AB, const base::Vec3& p_B) {
  return FromEigen(Eigen::Vector3d(ToEigen(X_AB.orientation) * ToEigen(p_B) + ToEigen(X_AB.position_m)));
}

Rigid NudgedPose(const Rigid& X_LB, double yaw_rad, const base::Vec3& shift_space_m) {
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY()));
  return {.orientation = FromEigen((yaw * ToEigen(X_LB.orientation)).normalized()),
          .position_m = FromEigen(Eigen::Vector3d(ToEigen(X_LB.position_m) + ToEigen(shift_space_m)))};
}

double Distance_m(const Rigid& a, const Rigid& b, const base::Vec3& point_base_m) {
  return (ToEigen(TransformPoint(a, point_base_m)) - ToEigen(TransformPoint(b, point_base_m))).norm();
}

double Angle_rad(const Rigid& a, const Rigid& b) {
  return ToEigen(a.orientation).normalized().angularDistance(ToEigen(b.orientation).normalized());
}

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
