// The tool's field with all derivatives that calibration needs: by pose, sensor position, moment, core. The tracker's
// model (docs/theory/tracking.md (2.1)), written for derivatives rather than for speed.
#pragma once

#include <Eigen/Core>

#include "service/base/device_geometry.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::calibration {

// Magnet's centre and axis with the tangents along which it turns.
struct ToolFrame {
  Eigen::Vector3d position_base_m;
  Eigen::Vector3d axis_base;
  Eigen::Vector3d e1, e2;
};
ToolFrame MakeToolFrame(const Eigen::Vector3d& position_base_m, const Eigen::Vector3d& axis_base) noexcept;

// Per unit moment, frame B.
struct ToolField {
  Eigen::Vector3d direct = Eigen::Vector3d::Zero();  // of the magnet alone
  Eigen::Vector3d image = Eigen::Vector3d::Zero();   // of the core at kappa = 1
  // Of direct + kappa image:
  Eigen::Matrix<double, 3, 5> by_pose = Eigen::Matrix<double, 3, 5>::Zero();  // position, turns about e1, e2
  Eigen::Matrix3d by_sensor = Eigen::Matrix3d::Zero();                        // by the place of observation
};

// One place of observation, with its image in the core.
class FieldAtSensor {
 public:
  FieldAtSensor(const Eigen::Vector3d& sensor_base_m, double core_radius_m);

  // `unit`: the magnet with moment 1.
  ToolField Evaluate(const magnetics::DiscMagnet& unit, double kappa, const ToolFrame& tool) const noexcept;

 private:
  void AddImage(const magnetics::DiscMagnet& unit, double kappa, const ToolFrame& tool,
                ToolField& field) const noexcept;

  Eigen::Vector3d sensor_base_m_;
  double core_radius_m_;
};

// Clearance of the magnet and the hull with its derivative by the pose. docs/theory/tracking.md (8.1)
struct HullGap {
  double gap_m = 0;
  Eigen::Matrix<double, 1, 5> by_pose = Eigen::Matrix<double, 1, 5>::Zero();
};
HullGap GapToHull(const base::MagnetGeometry& magnet, double hull_radius_m, const ToolFrame& tool) noexcept;

// What a steel plane under the base, at strength 1, adds at a sensor. docs/theory/calibration.md (2.2)

// The field of what stands at the base, as if there were no steel, with its derivatives by N unknowns and by the place.
template <int N>
struct PlacedField {
  Eigen::Vector3d B = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, N> by = Eigen::Matrix<double, 3, N>::Zero();
  Eigen::Matrix3d by_place = Eigen::Matrix3d::Zero();
};

template <int N>
struct SteelResponse {
  PlacedField<N> field;                               // at the sensor; by_place: by the sensor's
  Eigen::Vector3d of_core = Eigen::Vector3d::Zero();  // the core's share in field.B
  Eigen::Vector3d by_height = Eigen::Vector3d::Zero();
};

// M s + (0, 0, 2 height), M = diag(1, 1, -1)
inline Eigen::Vector3d MirroredPlace(double height_m, const Eigen::Vector3d& place_m) {
  return {place_m.x(), place_m.y(), 2 * height_m - place_m.z()};
}

// `mirrored`, `centre`: the base's field at the mirror images of the sensor and of the core's centre. With M the
// mirror, U = -M B(centre) and the core's response to it, K(s) = kappa (a/r)^3 (3 n n^T - I):
//   B_steel = -M B(mirrored) + K U
template <int N>
SteelResponse<N> SteelResponseOf(const Eigen::Vector3d& sensor_m, double core_radius_m, double kappa,
                                 const PlacedField<N>& mirrored, const PlacedField<N>& centre) {
  using Eigen::Matrix3d;
  using Eigen::Vector3d;
  const Vector3d M(1, 1, -1);
  const Vector3d up(0, 0, 2);
  SteelResponse<N> answer;
  answer.field.B = -M.cwiseProduct(mirrored.B);
  answer.field.by = -(M.asDiagonal() * mirrored.by);
  answer.field.by_place = -(M.asDiagonal() * mirrored.by_place * M.asDiagonal());
  answer.by_height = -M.cwiseProduct(mirrored.by_place * up);
  if (!(core_radius_m > 0)) return answer;
  const double r = sensor_m.norm();
  const Vector3d n = sensor_m / r;
  const double g = core_radius_m / r;
  const Matrix3d K = (kappa * g * g * g) * (3 * n * n.transpose() - Matrix3d::Identity());
  const Vector3d U = -M.cwiseProduct(centre.B);
  answer.of_core = K * U;
  answer.field.B += answer.of_core;
  answer.field.by -= K * (M.asDiagonal() * centre.by);
  answer.field.by_place += (3 * kappa * g * g * g / r) * (n.dot(U) * (Matrix3d::Identity() - 5 * n * n.transpose()) +
                                                          n * U.transpose() + U * n.transpose());
  answer.by_height -= K * M.cwiseProduct(centre.by_place * up);
  return answer;
}

}  // namespace omni::calibration
