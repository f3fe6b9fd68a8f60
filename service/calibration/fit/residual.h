// One sensor's reading of the tool against the model, with its derivatives by everything unknown.
// docs/theory/calibration.md (1.1), (1.3)
#pragma once

#include <Eigen/Core>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/calibration/fit/parameters.h"
#include "service/calibration/fit/tool_field.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::calibration {

// A sample's own unknowns: position (3), turn of the axis (2), remanence of the core as currents (3).
inline constexpr int kOwn = 8;
// What a sample's reading of one sensor depends on: that sensor's unknowns, then the shared ones.
inline constexpr int kLocal = kSensorUnknowns + kSampleShared;
using LocalJacobian = Eigen::Matrix<double, 3, kLocal>;

// Everything about the array that one linearisation needs.
struct ArrayState {
  std::vector<SensorState> sensors;
  std::vector<FieldAtSensor> fields;
  base::SteelPlane steel;                  // from the core's centre
  std::vector<FieldAtSensor> mirrored;     // at the sensors' images in the steel ...
  std::vector<FieldAtSensor> centre;       // ... and at that of the core's centre: one
  std::vector<Eigen::Matrix3d> remanence;  // reading per unit of remanence, T
  magnetics::DiscMagnet unit;
  double kappa = 0;
};
// remanence_A: its unit, Tolerances::remanence_A.
ArrayState MakeArrayState(const Parameters& parameters, const base::Calibration& nominal, double remanence_A);

// r = E N (m (direct + kappa image + steel) + ambient) + map (remanence + kept) - y, T. (1.1)
struct Residual {
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, kOwn> own;
  LocalJacobian array;
};
// Of sensor i; `tau` in [-1, 1] over the recording; `remanence` in its unit; `kept`: Observation::kept; y: the reading,
// T.
Residual ComputeResidual(const Parameters& parameters, const ArrayState& array, std::size_t i, double tau,
                         const ToolFrame& frame, const Eigen::Vector3d& remanence,
                         const Eigen::Matrix<double, 3, 2>& kept, const Eigen::Vector3d& y);

// The gap of a sample that touches the hull, m, with its derivatives by the pose and by the shared unknowns.
struct TouchResidual {
  double gap_m = 0;
  Eigen::Matrix<double, 1, 5> by_pose;
  Eigen::Matrix<double, 1, kSampleShared> by_shared;
};
TouchResidual CompareTouch(const Parameters& parameters, const ToolFrame& frame);

}  // namespace omni::calibration
