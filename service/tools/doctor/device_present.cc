// Does the service have a base to talk to?
#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding LookForDevice(const Surroundings& surroundings) {
  if (!surroundings.service.running) {
    return {Verdict::kWarn, "unknown while omnid does not run", "fix \"service\" first"};
  }
  const nlohmann::json& status = surroundings.service.status;
  const std::string name = DeviceName(status);
  if (name == "-") {
    return {Verdict::kFail, "omnid has no device: " + TextAt(status, "/device/absent"),
            "connect the base, or run the simulation with `omnid --device twin`"};
  }
  return {Verdict::kOk, name, {}};
}

}  // namespace omni::tools
