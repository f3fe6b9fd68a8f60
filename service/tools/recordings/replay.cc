#include "service/tools/recordings/report.h"

#include <cstdarg>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "firmware/wire/names.h"
#include "service/device/recording/recording_reader.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

using Count = unsigned long long;

__attribute__((format(printf, 1, 2))) std::string Line(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return std::string(text) + "\n";
}

std::string Date(std::int64_t unix_s) {
  const std::time_t time = unix_s;
  std::tm utc{};
  char text[40];
  if (gmtime_r(&time, &utc) == nullptr || std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc) == 0) {
    return "an unknown time";
  }
  return text;
}

std::string DeviceLine(const device::RecordingInfo& info) {
  return Line("device    %s, serial %s%s%s, up to %.3g A, recorded %s", info.name.c_str(), info.serial.c_str(),
              info.simulation ? ", a simulation" : "", info.virtual_time ? ", virtual time" : "", info.current_max_A,
              Date(info.begun_unix_s).c_str());
}

std::string ScanLines(const device::RecordingSummary& summary) {
  std::string text = Line("scans     %llu in %.3f s, largest measured current %.2f A", Count{summary.scans},
                          summary.duration_s, summary.current_peak_A);
  text += Line("gaps      %llu ticks missing; longest %.3f ms, at %.3f s; %llu stamps that do not advance",
               Count{summary.missed}, summary.longest_gap_s * 1e3, summary.longest_gap_at_s, Count{summary.backward});
  text += Line("commands  %llu, %llu of them refused", Count{summary.commands}, Count{summary.refused_commands});
  if (summary.lost > 0) text += Line("lost      %llu records: the recorder's ring was full", Count{summary.lost});
  return text;
}

std::string FaultLines(const device::RecordingSummary& summary) {
  std::string text;
  for (unsigned bit = 0; bit < summary.faults.size(); ++bit) {
    const device::RecordedFault& fault = summary.faults[bit];
    if (fault.scans == 0) continue;
    text += Line("fault     %s: in %llu scans, first at %.3f s", wire::FaultName(1U << bit), Count{fault.scans},
                 fault.first_s);
  }
  return text.empty() ? Line("faults    none") : text;
}

const char* EndWords(device::ReadStatus status) {
  switch (status) {
    case device::ReadStatus::kScan:
    case device::ReadStatus::kTimeout:
      return "closed by its writer";
    case device::ReadStatus::kGone:
      return "the device was disconnected";
    case device::ReadStatus::kEnd:
      return "the recorded run had ended";
  }
  return "";
}

std::string EndText(const device::RecordingSummary& summary) {
  return summary.cut.empty() ? EndWords(summary.last_status) : summary.cut;
}

}  // namespace

nlohmann::ordered_json RecordingJson(const std::string& path, const device::RecordingSummary& summary) {
  using nlohmann::ordered_json;
  ordered_json faults = ordered_json::array();
  for (unsigned bit = 0; bit < summary.faults.size(); ++bit) {
    const device::RecordedFault& fault = summary.faults[bit];
    if (fault.scans == 0) continue;
    faults.push_back({{"name", wire::FaultName(1U << bit)}, {"scans", fault.scans}, {"first_s", fault.first_s}});
  }
  return {{"file", path},
          {"bytes", summary.bytes},
          {"device",
           {{"name", summary.info.name},
            {"serial", summary.info.serial},
            {"simulation", summary.info.simulation},
            {"virtual_time", summary.info.virtual_time},
            {"current_max_A", summary.info.current_max_A}}},
          {"begun_unix_s", summary.info.begun_unix_s},
          {"duration_s", summary.duration_s},
          {"scans", summary.scans},
          {"missed_ticks", summary.missed},
          {"backward_stamps", summary.backward},
          {"longest_gap_s", summary.longest_gap_s},
          {"longest_gap_at_s", summary.longest_gap_at_s},
          {"commands", summary.commands},
          {"refused_commands", summary.refused_commands},
          {"lost_records", summary.lost},
          {"current_peak_A", summary.current_peak_A},
          {"faults", std::move(faults)},
          {"whole", summary.cut.empty()},
          {"end", EndText(summary)}};
}

std::string RecordingText(const std::string& path, const device::RecordingSummary& summary) {
  return path + "\n" + DeviceLine(summary.info) + ScanLines(summary) + FaultLines(summary) + "end       " +
         EndText(summary) + "\n";
}

// omni replay: summary of a device recording.

namespace {

struct ReplayArguments {
  std::string path;
  bool as_json = false;
};

int Replay(const ReplayArguments& arguments) {
  const auto summary = device::SummariseRecording(arguments.path);
  if (!summary.ok()) return FailWith(arguments.as_json, "omni replay", summary.error());
  if (arguments.as_json) {
    PrintJson(RecordingJson(arguments.path, *summary));
  } else {
    Print(RecordingText(arguments.path, *summary));
  }
  return kExitOk;
}

}  // namespace

void AddReplay(Command& app) {
  auto arguments = std::make_shared<ReplayArguments>();
  Command replay =
      app.AddCommand("replay", "summarise a recording of omnid --record-device; omnid --device replay:FILE plays it");
  replay.Add("file", arguments->path, "the recording").Required();
  replay.Add("--json", arguments->as_json, "as JSON");
  replay.SetAction(arguments, Replay);
}

}  // namespace omni::tools
