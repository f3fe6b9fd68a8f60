// Where the pen was in each sample, without a start value: the tracker's cold start on the nominal array.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/calibration/types.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::calibration {

struct ColdPose {
  bool found = false;  // false: the readings fit no pose within the tolerances
  Eigen::Vector3d position_base_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_base = -Eigen::Vector3d::UnitZ();
};

class ColdStart {
 public:
  // `nominal` with measured maps and background.
  static base::Result<ColdStart> Make(const base::Calibration& nominal, const Tolerances& tolerances);

  ColdPose FindPose(const Sample& sample) const;

 private:
  explicit ColdStart(tracker::StaticSolver solver) : solver_(std::move(solver)) {}

  tracker::StaticSolver solver_;
};

}  // namespace omni::calibration
