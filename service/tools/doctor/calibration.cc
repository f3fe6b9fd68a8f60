// Is the base calibrated, and does the calibration fit it?
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {
namespace {

constexpr const char* kCalibrate = "calibrate it: omni calibrate";

}  // namespace

Finding CheckCalibration(const Surroundings& surroundings) {
  const auto& status = surroundings.service.status;
  if (!surroundings.service.running) {
    return {Verdict::kWarn, "unknown while omnid does not run", "fix \"service\" first"};
  }
  if (DeviceName(status) == "-") return {Verdict::kWarn, "unknown without a device", "fix \"device\" first"};
  const std::string refused = TextAt(status, "/calibration_refused"), file = TextAt(status, "/calibration/file");
  const bool never = refused == "-" && file == "-";
  if (const std::string misfit = TextAt(status, "/calibration_misfit"); misfit != "-") {
    return {Verdict::kFail, misfit,
            never ? kCalibrate : "move other magnets and steel away, then calibrate again: omni calibrate --replace"};
  }
  if (refused != "-") return {Verdict::kWarn, refused, "omni calibrate --replace, or omni calibrate --restore"};
  if (never) return {Verdict::kWarn, "never calibrated: the base uses its nominal geometry", kCalibrate};
  const std::string shipped = TrueAt(status, "/calibration/shipped") ? "shipped with the twin: " : "";
  const std::string note = TextAt(status, "/calibration/note");
  return {Verdict::kOk,
          shipped + file + " of " + TextAt(status, "/calibration/date") + (note == "-" ? "" : ", " + note),
          {}};
}

}  // namespace omni::tools
