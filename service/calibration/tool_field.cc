#include "service/calibration/tool_field.h"

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

FieldAtSensor::FieldAtSensor(const Vector3d& sensor_base_m, double core_radius_m)
    : sensor_base_m_(sensor_base_m), core_radius_m_(core_radius_m) {
  for (int axis = 0; core_radius_m > 0 && axis < 3; ++axis) {
    images_[static_cast<std::size_t>(axis)] =
        magnetics::ImageInCore(Vector3d::Unit(axis), sensor_base_m, core_radius_m, 1);
  }
}

// B_e(s; m, P) = m . B_image(P; e at s): rows of field and gradient come from the images of e, the derivative by s from
// the image of m.
void FieldAtSensor::AddImage(const magnetics::MagnetPoint& point, double kappa, const ToolFrame& tool,
                             ToolField& field) const noexcept {
  const Vector3d& u = tool.axis_base;
  const Vector3d P = tool.position_base_m + magnetics::PointOffset(point, tool.e1, tool.e2, u);
  // Turning u by e1 carries the ring along: de1 = -u, du = e1.
  const Vector3d P_1 = point.axial_m * tool.e1 - point.ring_1_m * u;
  const Vector3d P_2 = point.axial_m * tool.e2 - point.ring_2_m * u;
  for (int axis = 0; axis < 3; ++axis) {
    const magnetics::CoreImage& image = images_[static_cast<std::size_t>(axis)];
    const Vector3d B = point.share * magnetics::CoreImageField(image, P);
    const Vector3d by_place = point.share * (magnetics::CoreImageGradient(image, P) * u);
    field.image[axis] += B.dot(u);
    field.by_pose.block<1, 3>(axis, 0) += kappa * by_place.transpose();
    field.by_pose(axis, 3) += kappa * (by_place.dot(P_1) + B.dot(tool.e1));
    field.by_pose(axis, 4) += kappa * (by_place.dot(P_2) + B.dot(tool.e2));
  }
  const magnetics::CoreImage image = magnetics::ImageInCore(point.share * u, P, core_radius_m_, 1);
  field.by_sensor += kappa * magnetics::CoreImageGradient(image, sensor_base_m_);
}

ToolField FieldAtSensor::Evaluate(const magnetics::DiscMagnet& unit, double kappa,
                                  const ToolFrame& tool) const noexcept {
  const Vector3d d = sensor_base_m_ - tool.position_base_m;
  ToolField field;
  field.direct = magnetics::ZonalField(unit.zonal, tool.axis_base, d);
  field.by_sensor = magnetics::ZonalGradient(unit.zonal, tool.axis_base, d);
  const Matrix3d by_axis = magnetics::ZonalAxisDerivative(unit.zonal, tool.axis_base, d);
  field.by_pose.leftCols<3>() = -field.by_sensor;
  field.by_pose.col(3) = by_axis * tool.e1;
  field.by_pose.col(4) = by_axis * tool.e2;
  if (!(core_radius_m_ > 0)) return field;
  for (int i = 0; i < unit.point_count; ++i) AddImage(unit.points[static_cast<std::size_t>(i)], kappa, tool, field);
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
