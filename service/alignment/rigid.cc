#include "service/alignment/rigid.h"

#include <Eigen/Geometry>
#include <cmath>

#include "service/base/eigen.h"

namespace omni::alignment {
namespace {

using base::FromEigen;
using base::ToEigen;

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

}  // namespace omni::alignment
