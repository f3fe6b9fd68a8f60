#include "service/tools/status/status.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/protocol/text.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

using nlohmann::json;

std::string Line(const char* title, const std::string& text) {
  char head[24];
  std::snprintf(head, sizeof(head), "%-10s ", title);
  return head + text + "\n";
}

std::string Millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f", metres * 1e3);
  return text;
}

// A vector of metres as millimetres, or of newtons with `scale` 1.
std::string Vector(const json& values, double scale, const char* format) {
  if (values.size() != 3) return "-";
  std::string text;
  for (const json& value : values) {
    char number[32];
    std::snprintf(number, sizeof(number), format, value.is_number() ? value.get<double>() * scale : std::nan(""));
    text += (text.empty() ? "(" : ", ") + std::string(number);
  }
  return text + ")";
}

std::string Duration(double seconds) {
  if (!(seconds >= 0 && seconds < 1e12)) return "-";
  const auto s = static_cast<long long>(seconds);
  char text[64];
  std::snprintf(text, sizeof(text), "%lld:%02lld:%02lld", s / 3600, s / 60 % 60, s % 60);
  return text;
}

std::string DeviceLine(const json& status) {
  const std::string name = DeviceName(status);
  if (name == "-") return "none: " + TextAt(status, "/device/absent");
  std::string text = name + ", " + TextAt(status, "/device/received") + " measurements, " +
                     TextAt(status, "/device/missed") + " missed";
  for (const json& fault : ArrayAt(status, "/device/faults")) {
    text += ", fault: " + (fault.is_string() ? protocol::Printable(fault.get<std::string>()) : fault.dump());
  }
  if (TrueAt(status, "/device/waits_for_person")) text += "; coils off until `omni device selftest`";
  return text;
}

std::string TickLine(const json& status) {
  return TextAt(status, "/tick/count") + " ticks of 1 ms, " + TextAt(status, "/tick/late") +
         " late; computing time median " + TextAt(status, "/tick/us_median", 1) + " us, p99 " +
         TextAt(status, "/tick/us_p99", 1) + " us, max " + TextAt(status, "/tick/us_max", 1) +
         " us; the base applies new currents " + TextAt(status, "/tick/response_us", 0) + " us after the sample";
}

// "omni-tick, omni-control": those that have it now, whoever gave it to them.
std::string RealtimeThreads(const json& status) {
  std::string names;
  for (const json& thread : ArrayAt(status, "/tick/realtime_threads")) {
    if (TrueAt(thread, "/realtime")) names += (names.empty() ? "" : ", ") + TextAt(thread, "/name");
  }
  return names;
}

std::string RealtimeLine(const json& status) {
  const std::string threads = RealtimeThreads(status);
  if (TrueAt(status, "/tick/realtime")) return "granted" + (threads.empty() ? "" : ": " + threads);
  if (!threads.empty()) return "since the start: " + threads;
  const std::string reason = TextAt(status, "/tick/realtime_reason");
  return reason == "-" || reason.empty() ? "not requested" : "refused: " + reason;
}

std::string TrackingLine(const json& status) {
  return TextAt(status, "/tracking/status") + ", tip " + Vector(ArrayAt(status, "/tracking/position_m"), 1e3, "%.1f") +
         " mm from the base's centre, magnet " + Millimetres(NumberAt(status, "/tracking/gap_m")) +
         " mm from the hull, uncertainty " + TextAt(status, "/tracking/sigma_mm", 2) + " mm";
}

std::string ForceLine(const json& status) {
  return Vector(ArrayAt(status, "/force/last_N"), 1, "%.2f") + " N" +
         (TrueAt(status, "/force/contact") ? ", in contact" : "");
}

std::string SceneLine(const json& status) {
  const std::string name = TextAt(status, "/scene/name");
  if (name == "-" || name.empty()) return "none";
  return name + ", " + TextAt(status, "/scene/triangles") + " triangles, number " +
         TextAt(status, "/scene/generation") + " since omnid started";
}

// Empty: the scene has no soft body.
std::string SoftLine(const json& status) {
  const double objects = NumberAt(status, "/scene/soft_bodies/objects"),
               done = NumberAt(status, "/scene/soft_bodies/done");
  if (!(objects > 0)) return {};
  std::string text = TextAt(status, "/scene/soft_bodies/ready") + " of " +
                     TextAt(status, "/scene/soft_bodies/objects") + " soft bodies ready";
  if (done < 1)
    text += ", " + std::to_string(static_cast<int>(100 * std::clamp(done, 0.0, 1.0))) +
            " %; a simple model is used until then";
  if (NumberAt(status, "/scene/soft_bodies/failed") > 0) {
    text += ", " + TextAt(status, "/scene/soft_bodies/failed") + " failed (see problems)";
  }
  return text;
}

std::string CalibrationLine(const json& status) {
  const std::string file = TextAt(status, "/calibration/file");
  const std::string misfit =
      TextAt(status, "/calibration_misfit") == "-" ? "" : "; does not fit this base (see problem)";
  if (TextAt(status, "/calibration_refused") != "-") {
    return "no: the file was rejected (see problem), the base uses its nominal geometry" + misfit;
  }
  if (file == "-") return "never: the base uses its nominal geometry; to calibrate it: `omni calibrate`" + misfit;
  const std::string note = TextAt(status, "/calibration/note");
  return (TrueAt(status, "/calibration/shipped") ? "shipped with the twin: " : "") + file + " of " +
         TextAt(status, "/calibration/date") + ", expected error " +
         TextAt(status, "/calibration/expected_error_mm", 2) + " mm" + (note == "-" ? "" : ", " + note) + misfit;
}

// "select: press, key:KEY_SPACE; menu: flick; ..."
std::string MappingLine(const json& status) {
  std::string text;
  const json::json_pointer where("/inputs/mapping");
  if (!status.contains(where) || !status[where].is_object()) return text;
  for (const auto& [component, names] : status[where].items()) {
    if (!names.is_array() || names.empty()) continue;
    text += (text.empty() ? "" : "; ") + component + ":";
    for (std::size_t i = 0; i < names.size(); ++i) {
      text += (i == 0 ? " " : ", ") + (names[i].is_string() ? names[i].get<std::string>() : names[i].dump());
    }
  }
  return protocol::Printable(text);
}

// Sources that are on or have been on.
std::string SourcesLine(const json& status) {
  std::string text;
  for (const json& source : ArrayAt(status, "/inputs/sources")) {
    if (!TrueAt(source, "/on") && !(NumberAt(source, "/times") > 0)) continue;
    text += (text.empty() ? "" : ", ") + TextAt(source, "/name") + " " + TextAt(source, "/times") +
            (TrueAt(source, "/on") ? " (on)" : "");
  }
  return text;
}

std::string KeyDeviceLine(const json& device) {
  const std::string paths = TextAt(device, "/paths");
  const std::string problem = TextAt(device, "/problem");
  if (!paths.empty() && paths != "-") return TextAt(device, "/rule") + ": " + paths;
  return TextAt(device, "/rule") + ": " + (problem.empty() || problem == "-" ? "not connected" : problem);
}

std::string Megabytes(const json& status, const char* pointer) {
  return std::to_string(static_cast<long>(std::ceil(std::clamp(NumberAt(status, pointer), 0.0, 1e6)))) + " MB";
}

// Empty: no scene takes memory, and none is being built.
std::string MemoryLine(const json& status) {
  if (!(NumberAt(status, "/builds/kept_MB") > 0) && ArrayAt(status, "/builds/builders").empty()) return {};
  return "scenes keep " + Megabytes(status, "/builds/kept_MB") + " of " + Megabytes(status, "/builds/kept_limit_MB") +
         ", builders have " + Megabytes(status, "/builds/building_MB") + " of " +
         Megabytes(status, "/builds/building_limit_MB");
}

std::string BuilderLine(const json& row) {
  return TextAt(row, "/file") + (TrueAt(row, "/soft_body") ? ", a soft body" : "") + ": " + TextAt(row, "/state");
}

std::string ClientLine(const json& client) {
  if (TrueAt(client, "/monitor"))
    return "monitor \"" + TextAt(client, "/application") + "\" (pid " + TextAt(client, "/pid") + ")";
  return "\"" + TextAt(client, "/application") + "\" (pid " + TextAt(client, "/pid") + "), session " +
         TextAt(client, "/session") + (TrueAt(client, "/owner") ? ", controls the force" : "") + ", scene " +
         TextAt(client, "/scene");
}

}  // namespace

std::string StatusText(const json& status) {
  std::string text = SimulationLine(status);
  text += Line("omnid", TextAt(status, "/service/version") + ", pid " + TextAt(status, "/service/pid") + ", up " +
                            Duration(NumberAt(status, "/service/uptime_s")));
  text += Line("device", DeviceLine(status));
  text += Line("calibrated", CalibrationLine(status));
  text += Line("tick", TickLine(status));
  text += Line("real-time", RealtimeLine(status));
  text += Line("pen", TrackingLine(status));
  text += Line("force", ForceLine(status));
  text += Line("scene", SceneLine(status));
  const std::string soft = SoftLine(status);
  if (!soft.empty()) text += Line("soft", soft);
  if (const double sculpted = NumberAt(status, "/scene/sculpted"); sculpted > 0) {
    text += Line("sculpted", Plural(static_cast<std::size_t>(sculpted), "object") + "; see `omni scene edits`");
  }
  for (const json& line : ArrayAt(status, "/scene/strokes")) {
    if (line.is_string()) text += Line("strokes", line.get<std::string>());
  }
  const std::string race = RaceText(status);
  if (!race.empty()) text += Line("race", race);
  if (const std::string mapping = MappingLine(status); !mapping.empty()) text += Line("inputs", mapping);
  if (const std::string sources = SourcesLine(status); !sources.empty()) text += Line("pressed", sources);
  for (const json& device : ArrayAt(status, "/inputs/devices")) text += Line("keys", KeyDeviceLine(device));
  text += Line("alignment", TrueAt(status, "/aligned") ? "aligned with the headset"
                                                       : "not aligned: the base is assumed to be in front of you");
  if (const std::string memory = MemoryLine(status); !memory.empty()) text += Line("memory", memory);
  for (const json& row : ArrayAt(status, "/builds/builders")) text += Line("builds", BuilderLine(row));
  const json& clients = ArrayAt(status, "/clients");
  if (clients.empty()) text += Line("clients", "none");
  for (const json& client : clients) text += Line("client", ClientLine(client));
  for (const json& problem : ArrayAt(status, "/problems")) {
    text += Line("problem", problem.is_string() ? protocol::Printable(problem.get<std::string>()) : problem.dump());
  }
  return text;
}

// omni status: the current state of the service.

namespace {

struct StatusArguments {
  std::string socket;
  bool as_json = false;
};

int Status(const StatusArguments& arguments) {
  const base::Result<nlohmann::json> status = FetchStatus(arguments.socket);
  if (!status.ok()) return FailWith(arguments.as_json, "omni status", status.error(), kExitNoService);
  if (arguments.as_json) {
    PrintJson(*status);
  } else {
    Print(StatusText(*status));
  }
  return kExitOk;
}

}  // namespace

void AddStatus(Command& app) {
  auto arguments = std::make_shared<StatusArguments>();
  Command status = app.AddCommand("status", "show what omnid does: device, tick, pen, force, clients, problems");
  status.Add("--json", arguments->as_json, "as JSON");
  AddSocket(status, arguments->socket);
  status.SetAction(arguments, Status);
}

}  // namespace omni::tools
