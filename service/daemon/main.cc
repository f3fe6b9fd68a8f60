// omnid: the service. Composition root: device, loop, control plane.
#include <exception>
#include <string>

#include "service/console/command.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/run.h"

namespace {

int ParseAndRun(int argc, char** argv) {
  omni::daemon::RunOptions options;
  omni::console::Program app("omnid", omni::daemon::kOmnidAbout, OMNI_VERSION);
  omni::daemon::AddOptions(app, options);
  if (const auto ended = app.Parse(argc, argv)) return *ended;
  if (options.replay_fast && !omni::daemon::IsReplay(options.device)) {
    return omni::console::FailUsage("omnid", "--replay-fast: needs --device replay:FILE");
  }
  if (const std::string problem = omni::daemon::OptionsProblem(options); !problem.empty()) {
    return omni::console::FailUsage("omnid", problem);
  }
  if (const auto way = omni::daemon::MakeWay(options); !way.ok()) return omni::console::Fail("omnid", way.error());
  return omni::daemon::Run(options);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return ParseAndRun(argc, argv);
  } catch (const std::exception& error) {
    return omni::console::Fail("omnid", error.what());
  }
}
