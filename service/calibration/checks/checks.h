// Refuses recordings from which no calibration should be made, with the reason and what to do. Empty: fine.
#pragma once

#include <string>
#include <vector>

#include "service/base/calibration.h"
#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/options.h"
#include "service/calibration/fit/report.h"
#include "service/calibration/fit/samples.h"
#include "service/calibration/fit/start.h"

namespace omni::calibration {

// What the coils did at each sensor: two sensors that are swapped, a coil that is backwards or weak, a magnet near.
std::string ResponsesProblem(const base::Calibration& nominal, const std::vector<CoilResponse>& responses);

// Sizes and numbers: sensors, currents, maps, noise.
std::string RecordingProblem(const base::Calibration& nominal, const Recording& recording, const Limits& limits);

// What the cold poses say: enough of them, moving, all round, the pen the right way round.
std::string PosesProblem(const base::Calibration& nominal, const Recording& recording,
                         const std::vector<ColdPose>& poses, const Limits& limits);

std::string ResultProblem(const Adjustment& adjustment, const Report& report, const Limits& limits);

}  // namespace omni::calibration
