// Rejects recordings from which no calibration should be made, with the reason and the remedy. Empty: accepted.
#pragma once

#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/start.h"
#include "service/calibration/types.h"

namespace omni::calibration {

// Checks each sensor's current maps: two sensors that are swapped, a coil that is reversed or weak, a magnet nearby.
std::string ResponsesProblem(const base::Calibration& nominal, const std::vector<CoilResponse>& responses);

// Sizes and numbers: sensors, currents, maps, noise.
std::string RecordingProblem(const base::Calibration& nominal, const Recording& recording, const Limits& limits);

// Checks the cold-start poses: enough of them, moving, all round, the pen the right way round.
std::string PosesProblem(const base::Calibration& nominal, const Recording& recording,
                         const std::vector<ColdPose>& poses, const Limits& limits);

std::string ResultProblem(const Adjustment& adjustment, const Report& report, const Limits& limits);

// From an adjustment to its report: residuals, parameters that the data did not determine, remaining error.
// docs/theory/calibration.md (5.1) - (5.6)

// Leaves samples, coverage, rejected, seconds to the caller.
Report AssessAdjustment(const Problem& problem, const Adjustment& adjustment);

}  // namespace omni::calibration
