// omnid: the service. Composition root: device, loop, control plane.
#include <exception>
#include <string>

#include "service/config/files/twin_file.h"
#include "service/console/command.h"
#include "service/daemon/check_options.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/run.h"

namespace {

int ParseAndRun(int argc, char** argv) {
  omni::daemon::RunOptions options;
  omni::console::Program app("omnid",
                             "omnid: tracks the pen, renders forces, serves OpenXR applications through the Omni layer",
                             OMNI_VERSION);
  app.Add("--device", options.device, omni::daemon::DeviceHelp())
      .Check("DEVICE", omni::daemon::DeviceProblem)
      .ShowDefault();
  app.Add("--replay-fast", options.replay_fast, "replay:FILE as fast as possible, with the recorded time stamps");
  app.Add("--device-file", options.device_file, "geometry and limits (default: the built-in omni.toml)");
  app.Add("--calibration", options.calibration_path,
          "file of omni calibrate (default: $XDG_CONFIG_HOME/omni/calibration.toml, if it is there)");
  app.Add("--alignments", options.alignment_path,
          "file of omni align (default: $XDG_CONFIG_HOME/omni/alignments.toml)");
  app.Add("--socket", options.socket_path, "control socket (default: $OMNI_SOCKET, else below $XDG_RUNTIME_DIR)");
  app.Add("--record", options.record_path, "CSV file with one line per tick");
  app.Add("--record-device", options.record_device_path, "file of all scans and commands, for --device replay:FILE");
  const omni::console::Option twin = app.Add("--twin", options.twin, omni::config::kTwinHelp);
  app.AddShort("--ideal", options.twin, omni::config::kIdeal, omni::config::kIdealHelp).Excludes(twin);
  app.Add("--twin-script", options.twin_script, "hand script (.json) of the twin");
  app.Add("--twin-hand", options.twin_hand,
          "socket on which a program leads the twin's hand (omni twin hand), in a folder of mode 0700");
  app.Add("--twin-record", options.twin_record, "CSV file of the twin's true pose and currents");
  app.Add("--twin-seed", options.twin_seed, "seed of the twin's noise and imperfections");
  app.Add("--hand", options.hand, "hand that holds the pen: left, right, or auto (the layer's default: right)")
      .OneOf({"auto", "left", "right"})
      .ShowDefault();
  app.Add("--log-level", options.log_level, "lowest level that is logged")
      .OneOf({"trace", "debug", "info", "warn", "error", "off"})
      .ShowDefault();
  app.Add("!--no-realtime", options.realtime, "do not request SCHED_FIFO and mlockall");
  if (const auto ended = app.Parse(argc, argv)) return *ended;
  if (options.replay_fast && !omni::daemon::IsReplay(options.device)) {
    return omni::console::Refuse("omnid", "--replay-fast: needs --device replay:FILE");
  }
  if (const std::string problem = omni::daemon::OptionsProblem(options); !problem.empty()) {
    return omni::console::Refuse("omnid", problem);
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
