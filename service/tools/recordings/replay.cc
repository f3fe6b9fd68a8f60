// omni replay: summary of a device recording.
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/device/recording/recording_reader.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/json_text.h"
#include "service/tools/common/text_output.h"
#include "service/tools/recordings/replay_text.h"

namespace omni::tools {
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
  replay.Run(arguments, Replay);
}

}  // namespace omni::tools
