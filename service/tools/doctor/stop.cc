// Is an emergency stop on? Then nothing is felt, whatever else is right.
#include "service/config/files/stop_file.h"
#include "service/protocol/text.h"
#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {
namespace {

constexpr const char* kRelease = "when it is safe: `omni stop --release`";

std::string Pressed(const std::string& by, const std::string& at) {
  return "pressed at " + at + (by.empty() || by == "-" ? "" : " by " + by);
}

}  // namespace

Finding CheckStop(const Surroundings& surroundings) {
  const nlohmann::json& status = surroundings.service.status;
  if (!surroundings.service.running) {
    const std::optional<config::StopRecord> stop = config::FindStop(surroundings.stop_file);
    if (!stop) return {Verdict::kOk, "not pressed", {}};
    return {Verdict::kWarn,
            protocol::Printable(Pressed(stop->by, stop->at)) + ": omnid will start without force (" +
                surroundings.stop_file + ")",
            std::string(kRelease) + " while omnid runs"};
  }
  const std::string problem = TextAt(status, "/stop/problem");
  const bool failed = !problem.empty() && problem != "-";
  if (TrueAt(status, "/stop/on")) {
    return {Verdict::kWarn,
            Pressed(TextAt(status, "/stop/by"), TextAt(status, "/stop/at")) + ": no force" +
                (failed ? "; it is forgotten when omnid ends: " + problem : ""),
            kRelease};
  }
  if (failed) return {Verdict::kWarn, "released, but the next omnid starts stopped: " + problem, "remove that file"};
  return {Verdict::kOk, "not pressed", {}};
}

}  // namespace omni::tools
