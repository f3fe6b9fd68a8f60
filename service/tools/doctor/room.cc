// Is a sensor faulty, another magnet near, or the room different from when the base was calibrated?
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding CheckRoom(const Surroundings& surroundings) {
  const auto& status = surroundings.service.status;
  if (!surroundings.service.running) {
    return {Verdict::kWarn, "unknown while omnid does not run", "fix \"service\" first"};
  }
  if (DeviceName(status) == "-") return {Verdict::kWarn, "unknown without a device", "fix \"device\" first"};
  const auto& rows = ArrayAt(status, "/room");
  if (rows.empty()) return {Verdict::kOk, "no sensor is faulty, no other magnet is near", {}};
  Finding finding{Verdict::kFail, {}, {}};
  for (const auto& row : rows) {
    const char* join = finding.what.empty() ? "" : "; ";
    finding.what += join + TextAt(row, "/what");
    finding.fix += join + TextAt(row, "/fix");
  }
  return finding;
}

}  // namespace omni::tools
