// From an adjustment to its report: residuals, parameters that the data did not determine, remaining error.
// docs/theory/calibration.md (5.1) - (5.6)
#pragma once

#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/report.h"

namespace omni::calibration {

// Leaves samples, coverage, rejected, seconds to the caller.
Report Assess(const Problem& problem, const Adjustment& adjustment);

}  // namespace omni::calibration
