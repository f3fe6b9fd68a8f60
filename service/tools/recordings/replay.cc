// omni replay: summary of a device recording.
#include <memory>
#include <string>

#include "service/device/recording/recording_reader.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"
#include "service/tools/common/text_output.h"
#include "service/tools/recordings/replay_text.h"

namespace omni::tools {
namespace {

int Replay(const std::string& path) {
  const auto summary = device::SummariseRecording(path);
  if (!summary.ok()) return Fail("omni replay", summary.error());
  Print(RecordingText(path, *summary));
  return kExitOk;
}

}  // namespace

void AddReplay(Command& app) {
  auto path = std::make_shared<std::string>();
  Command replay =
      app.AddCommand("replay", "summarise a recording of omnid --record-device; omnid --device replay:FILE plays it");
  replay.Add("file", *path, "the recording").Required();
  replay.Run(path, Replay);
}

}  // namespace omni::tools
