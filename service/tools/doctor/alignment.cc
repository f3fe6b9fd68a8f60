// Is the base's pose in the headset's space known?
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

Finding CheckAlignment(const Surroundings& surroundings) {
  const auto& status = surroundings.service.status;
  if (TrueAt(status, "/aligned")) return {Verdict::kOk, "aligned with the headset", {}};
  for (const nlohmann::json& row : ArrayAt(status, "/alignments/stored")) {
    if (TrueAt(row, "/drifted")) {
      return {Verdict::kWarn, "the alignment with " + TextAt(row, "/system") + " may be off by more than 10 mm by now",
              "touch mark 1 once: omni align --check --correct", "omni align --check --correct"};
    }
    if (!TrueAt(row, "/base_moved")) continue;
    return {Verdict::kWarn, "the base was turned or carried since it was aligned with " + TextAt(row, "/system"),
            "run omni align again; if it stands where it stood: omni align --restore", "omni align"};
  }
  if (const auto& stored = ArrayAt(status, "/alignments/stored"); !stored.empty()) {
    return {Verdict::kOk,
            std::to_string(stored.size()) + " stored (omni align --show), but no running application uses one",
            {}};
  }
  return {Verdict::kWarn, "not aligned: the base is assumed to be in front of you",
          "run omni align; until then place the base about 45 cm in front of you and 35 cm below your eyes, and "
          "recentre the headset",
          "omni align"};
}

}  // namespace omni::tools
