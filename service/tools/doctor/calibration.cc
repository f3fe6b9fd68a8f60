// Is the base calibrated, and does the calibration fit it?
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding CheckCalibration(const Surroundings& surroundings) {
  const auto& status = surroundings.service.status;
  if (!surroundings.service.running) {
    return {Verdict::kWarn, "unknown while omnid does not run", "fix \"service\" first"};
  }
  if (DeviceName(status) == "-") return {Verdict::kWarn, "unknown without a device", "fix \"device\" first"};
  const std::string refused = TextAt(status, "/calibration_refused"), file = TextAt(status, "/calibration/file");
  if (const std::string misfit = TextAt(status, "/calibration_misfit"); misfit != "-") {
    return {Verdict::kFail, misfit,
            "move other magnets and steel away, then calibrate again: omni calibrate --replace"};
  }
  if (refused != "-") return {Verdict::kWarn, refused, "omni calibrate --replace, or omni calibrate --restore"};
  if (file == "-") return {Verdict::kWarn, "none: the base uses its nominal geometry", "calibrate it: omni calibrate"};
  const std::string note = TextAt(status, "/calibration/note");
  return {Verdict::kOk, file + " of " + TextAt(status, "/calibration/date") + (note == "-" ? "" : ", " + note), {}};
}

}  // namespace omni::tools
