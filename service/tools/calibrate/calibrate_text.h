// What `omni calibrate` shows: steps, a progress bar, the hemisphere's coverage, the result.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/calibration/checks/coverage.h"
#include "service/calibration/checks/tip.h"
#include "service/calibration/checks/zero.h"
#include "service/calibration/fit/report.h"
#include "service/tools/calibrate/calibrate_session.h"

namespace omni::tools {

// Instruction for the current step, one line.
std::string StepText(CalibrationStep step, const SessionOptions& options);
// The upper hemisphere from above, the rim outside: one character per cell, '.' where the pen has not been, in one line
// per band from the top down.
std::string CoverageText(const calibration::Coverage& coverage);
// Residuals, parameters that were not fixed, and one word for the overall quality.
std::string ReportText(const calibration::Report& report);
// What was measured again, one line.
std::string ZeroText(const calibration::Zeroed& zeroed);
std::string TipText(const calibration::Tip& tip, double drawn_m);
// "excellent", "good", "fair" or "poor", by the error that the calibration leaves.
std::string QualityWord(double expected_error_m);

}  // namespace omni::tools
