// omnid: the service. Composition root: device, loop, control plane.
#include <CLI/CLI.hpp>
#include <exception>
#include <string>

#include "service/console/parse.h"
#include "service/daemon/check_options.h"
#include "service/daemon/open_device.h"
#include "service/daemon/run.h"

namespace {

int ParseAndRun(int argc, char** argv) {
  omni::daemon::RunOptions options;
  CLI::App app{"omnid: tracks the pen, renders forces, serves OpenXR applications through the Omni layer", "omnid"};
  app.footer(omni::console::kExitStatusHelp);
  omni::console::AddVersion(app, OMNI_VERSION);
  app.add_option("--device", options.device, omni::daemon::DeviceHelp())
      ->check(CLI::Validator(omni::daemon::DeviceProblem, "DEVICE"))
      ->capture_default_str();
  app.add_flag("--replay-fast", options.replay_fast, "replay:FILE as fast as possible, with the stamps of then");
  app.add_option("--device-file", options.device_file, "geometry and limits (default: the built-in omni.toml)");
  app.add_option("--calibration", options.calibration_path,
                 "file of omni calibrate (default: $XDG_CONFIG_HOME/omni/calibration.toml, if it is there)");
  app.add_option("--alignments", options.alignment_path,
                 "file of omni align (default: $XDG_CONFIG_HOME/omni/alignments.toml)");
  app.add_option("--socket", options.socket_path,
                 "control socket (default: $OMNI_SOCKET, else below $XDG_RUNTIME_DIR)");
  app.add_option("--record", options.record_path, "CSV file with one line a tick");
  app.add_option("--record-device", options.record_device_path, "file of all scans and commands, to replay");
  app.add_option("--twin-script", options.twin_script, "hand script (.json) of the twin");
  app.add_option("--twin-hand", options.twin_hand,
                 "socket on which a program leads the twin's hand (omni twin hand), in a folder of mode 0700");
  app.add_option("--twin-record", options.twin_record, "CSV file of the twin's true pose and currents");
  app.add_option("--twin-seed", options.twin_seed, "seed of the twin's noise and imperfections");
  app.add_option("--hand", options.hand, "hand that holds the pen: left, right, or auto (the layer's default: right)")
      ->check(omni::console::OneOf({"auto", "left", "right"}))
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "the least that is logged")
      ->check(omni::console::OneOf({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_flag("!--no-realtime", options.realtime, "do not ask for SCHED_FIFO and mlockall");
  app.final_callback([&options] {
    if (options.replay_fast && !omni::daemon::IsReplay(options.device)) {
      throw CLI::ValidationError("--replay-fast", "needs --device replay:FILE");
    }
  });
  if (const auto ended = omni::console::Parse(app, argc, argv)) return *ended;
  if (const std::string problem = omni::daemon::OptionsProblem(options); !problem.empty()) {
    omni::console::Fail("omnid", problem);
    return omni::console::kExitUsage;
  }
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
