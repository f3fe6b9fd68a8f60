// Where the pen was in each sample, without any hint: the tracker's cold start on the array as drawn.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "service/base/calibration.h"
#include "service/base/result.h"
#include "service/calibration/options.h"
#include "service/calibration/samples.h"

namespace omni::calibration {

struct ColdPose {
  bool found = false;  // false: the readings fit no pose within the tolerances
  Eigen::Vector3d position_base_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_base = -Eigen::Vector3d::UnitZ();
};

// `nominal` with measured maps and background. One pose a sample.
std::vector<ColdPose> ColdPoses(const base::Calibration& nominal, const Recording& recording,
                                const Tolerances& tolerances);

}  // namespace omni::calibration
