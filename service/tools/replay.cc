// omni replay: what a device recording holds.
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "service/device/recording_reader.h"
#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/replay_text.h"
#include "service/tools/text_output.h"

namespace omni::tools {
namespace {

int ShowRecording(const std::string& path) {
  const auto summary = device::SummariseRecording(path);
  if (!summary.ok()) return Fail("omni replay", summary.error());
  Print(RecordingText(path, *summary));
  return kExitOk;
}

}  // namespace

void AddReplay(CLI::App& app) {
  auto path = std::make_shared<std::string>();
  CLI::App* replay = app.add_subcommand(
      "replay", "what a recording of omnid --record-device holds; omnid --device replay:FILE plays it");
  replay->add_option("file", *path, "the recording")->required();
  replay->callback([path] { throw CLI::RuntimeError(ShowRecording(*path)); });
}

}  // namespace omni::tools
