// The tool's field with all derivatives that calibration needs: by pose, sensor position, moment, core. The tracker's
// model (docs/theory/tracking.md (2.1)), written for derivatives rather than for speed.
#pragma once

#include <Eigen/Core>

#include "service/base/calibration.h"
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

}  // namespace omni::calibration
