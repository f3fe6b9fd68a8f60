// Does omnid run, and is its version the same as ours?
#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding LookForService(const Surroundings& surroundings) {
  const ServiceAnswer& service = surroundings.service;
  if (service.on_demand) return {Verdict::kOk, "omnid does not run; systemd starts it with the first application", {}};
  if (!service.running) {
    return {Verdict::kFail, service.error, "run `omnid --device twin`, or `systemctl --user enable --now omnid.socket`",
            "systemctl --user enable --now omnid.socket"};
  }
  const std::string version = TextAt(service.status, "/service/version");
  if (version != OMNI_VERSION) {
    return {Verdict::kWarn, "omnid is version " + version + ", this is omni " OMNI_VERSION,
            "install the same version of both and restart omnid"};
  }
  const nlohmann::json& problems = ArrayAt(service.status, "/problems");
  if (!problems.empty() && problems.back().is_string()) {
    return {Verdict::kWarn, "omnid reports: " + problems.back().get<std::string>(), "see `omni status`"};
  }
  return {Verdict::kOk, "omnid " + version + " runs, pid " + TextAt(service.status, "/service/pid"), {}};
}

}  // namespace omni::tools
