// Is the base's place in the headset's space known?
#include "service/tools/doctor/diagnosis.h"
#include "service/tools/json_text.h"

namespace omni::tools {

Finding LookAtAlignment(const Surroundings& surroundings) {
  if (TrueAt(surroundings.service.status, "/aligned")) return {Verdict::kOk, "aligned with the headset", {}};
  return {Verdict::kWarn, "not aligned: the base is assumed in front of you",
          "put the base on the desk about 45 cm in front of you and 35 cm below your eyes, then recentre the headset"};
}

}  // namespace omni::tools
