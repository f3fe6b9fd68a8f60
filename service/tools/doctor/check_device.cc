// Is there a base, and is what is known of it right?
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/output.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

// Does the service have a base to talk to?
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

// Is the base calibrated, and does the calibration fit it?

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

// Is a sensor faulty, another magnet near, or the room different from when the base was calibrated?
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

// Is the base's pose in the headset's space known?
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
