#include "service/calibration/fit/tool_field.h"

#include <algorithm>
#include <cmath>

#include "service/magnetics/zonal.h"

namespace omni::calibration {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ToolFrame MakeToolFrame(const Vector3d& position_base_m, const Vector3d& axis_base) noexcept {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(axis_base);
  return {position_base_m, axis_base, basis.e1, basis.e2};
}

namespace {

// The tool seen from a fixed place: potential and field with their derivatives by the pose.
struct Seen {
  double potential;
  Vector3d B;
  Eigen::Matrix<double, 1, 5> potential_by_pose;
  Eigen::Matrix<double, 3, 5> B_by_pose;
  Matrix3d gradient;
};

Seen See(const magnetics::DiscMagnet& unit, const ToolFrame& tool, const Vector3d& place) {
  const Vector3d d = place - tool.position_base_m;
  Seen seen;
  seen.potential = magnetics::ZonalPotential(unit.zonal, tool.axis_base, d);
  seen.B = magnetics::ZonalField(unit.zonal, tool.axis_base, d);
  seen.gradient = magnetics::ZonalGradient(unit.zonal, tool.axis_base, d);
  const Vector3d potential_by_axis = magnetics::ZonalPotentialAxisDerivative(unit.zonal, tool.axis_base, d);
  const Matrix3d B_by_axis = magnetics::ZonalAxisDerivative(unit.zonal, tool.axis_base, d);
  seen.potential_by_pose << seen.B.transpose(), potential_by_axis.dot(tool.e1), potential_by_axis.dot(tool.e2);
  seen.B_by_pose << -seen.gradient, B_by_axis * tool.e1, B_by_axis * tool.e2;
  return seen;
}

}  // namespace

FieldAtSensor::FieldAtSensor(const Vector3d& sensor_base_m, double core_radius_m)
    : sensor_base_m_(sensor_base_m), core_radius_m_(core_radius_m) {}

// B_image(s) = -g^3 M B(s') - (a/r^2) (phi(s') - phi(0)) n,   g = a/r, M = I - 2 n n^T, s' = g^2 s, and with
// ds'/ds = g^2 M, dn/ds = P/r, P = I - n n^T, its derivative by s.                  docs/theory/tracking.md (2.1)
void FieldAtSensor::AddImage(const magnetics::DiscMagnet& unit, double kappa, const ToolFrame& tool,
                             ToolField& field) const noexcept {
  const double r = sensor_base_m_.norm();
  const Vector3d n = sensor_base_m_ / r;
  const double g = core_radius_m_ / r, g2 = g * g, g3 = g2 * g;
  const double potential_gain = g / r;
  const Matrix3d M = Matrix3d::Identity() - 2 * n * n.transpose();
  const Matrix3d P = Matrix3d::Identity() - n * n.transpose();
  const Seen image = See(unit, tool, g2 * sensor_base_m_);
  const Seen centre = See(unit, tool, Vector3d::Zero());
  const double potential = image.potential - centre.potential;
  field.image = -g3 * M * image.B - potential_gain * potential * n;
  field.by_pose +=
      kappa * (-g3 * M * image.B_by_pose - potential_gain * n * (image.potential_by_pose - centre.potential_by_pose));
  const Matrix3d of_mirror =
      (3 * M * image.B * n.transpose() + 2 * n.dot(image.B) * P + 2 * n * (P * image.B).transpose()) / r;
  const Matrix3d of_potential = (Matrix3d::Identity() - 3 * n * n.transpose()) * (potential / r);
  field.by_sensor += kappa * (g3 * (of_mirror - g2 * M * image.gradient * M) -
                              potential_gain * (of_potential - g2 * n * (M * image.B).transpose()));
}

ToolField FieldAtSensor::Evaluate(const magnetics::DiscMagnet& unit, double kappa,
                                  const ToolFrame& tool) const noexcept {
  const Seen seen = See(unit, tool, sensor_base_m_);
  ToolField field;
  field.direct = seen.B;
  field.by_sensor = seen.gradient;
  field.by_pose = seen.B_by_pose;
  if (core_radius_m_ > 0) AddImage(unit, kappa, tool, field);
  return field;
}

// h = |p.u|, rho = |p - (p.u) u|, s = rho - R, f = h - b: gap = |(max(s, 0), max(f, 0))| + min(max(s, f), 0) - hull.
HullGap GapToHull(const base::MagnetGeometry& magnet, double hull_radius_m, const ToolFrame& tool) noexcept {
  const Vector3d& p = tool.position_base_m;
  const Vector3d& u = tool.axis_base;
  if (magnet.shape == base::MagnetShape::kSphere) {
    HullGap gap;
    gap.gap_m = p.norm() - magnet.radius_m - hull_radius_m;
    gap.by_pose.head<3>() = p.normalized().transpose();
    return gap;
  }
  const double along = p.dot(u);
  const Vector3d across = p - along * u;
  const double rho = across.norm();
  const double sign = along < 0 ? -1.0 : 1.0;
  const double s = rho - magnet.radius_m;
  const double f = std::abs(along) - magnet.half_height_m;
  const double s_out = std::max(s, 0.0);
  const double f_out = std::max(f, 0.0);
  const double distance = std::hypot(s_out, f_out);
  // Weights of d rho and d h in d gap.
  const double by_rho = distance > 0 ? s_out / distance : (s > f ? 1.0 : 0.0);
  const double by_h = distance > 0 ? f_out / distance : (s > f ? 0.0 : 1.0);
  const Vector3d n = rho > 0 ? Vector3d(across / rho) : tool.e1;
  HullGap gap;
  gap.gap_m = distance + std::min(std::max(s, f), 0.0) - hull_radius_m;
  gap.by_pose.head<3>() = (by_rho * n + by_h * sign * u).transpose();
  gap.by_pose[3] = by_h * sign * p.dot(tool.e1) - by_rho * along * n.dot(tool.e1);
  gap.by_pose[4] = by_h * sign * p.dot(tool.e2) - by_rho * along * n.dot(tool.e2);
  return gap;
}

}  // namespace omni::calibration
