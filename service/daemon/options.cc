#include "service/daemon/options.h"

#include "service/config/files/twin_file.h"
#include "service/daemon/devices/open_device.h"

namespace omni::daemon {

void AddOptions(console::Program& omnid, RunOptions& options) {
  omnid.Add("--device", options.device, DeviceHelp()).Check("DEVICE", DeviceProblem).ShowDefault();
  omnid.Add("--replay-fast", options.replay_fast, "replay:FILE as fast as possible, with the recorded time stamps");
  omnid.Add("--device-file", options.device_file, "geometry and limits (default: the built-in omni.toml)");
  omnid.Add("--calibration", options.calibration_path,
            "file of omni calibrate (default: $XDG_CONFIG_HOME/omni/calibration.toml, if it is there)");
  omnid.Add("--alignments", options.alignment_path,
            "file of omni align (default: $XDG_CONFIG_HOME/omni/alignments.toml)");
  omnid.Add("--stop-file", options.stop_path,
            "file that keeps an emergency stop (default: $XDG_STATE_HOME/omni/emergency_stop.toml)");
  omnid.Add("--socket", options.socket_path, "control socket (default: $OMNI_SOCKET, else below $XDG_RUNTIME_DIR)");
  omnid.Add("--record", options.record_path, "CSV file with one line per tick");
  omnid.Add("--record-device", options.record_device_path, "file of all scans and commands, for --device replay:FILE");
  omnid.Add("--replace", options.replace, "recordings replace files that exist");
  const console::Option twin = omnid.Add("--twin", options.twin, config::kTwinHelp);
  omnid.AddShort("--ideal", options.twin, config::kIdeal, config::kIdealHelp).Excludes(twin);
  omnid.Add("--twin-script", options.twin_script, "hand script (.json) of the twin");
  omnid.Add("--twin-hand", options.twin_hand,
            "socket on which a program leads the twin's hand (omni twin hand), in a folder of mode 0700");
  omnid.Add("--twin-record", options.twin_record, "CSV file of the twin's true pose and currents");
  omnid.Add("--twin-seed", options.twin_seed, "seed of the twin's noise and imperfections");
  omnid.Add("--hand", options.hand, "hand that holds the pen: left, right, or auto (the layer's default: right)")
      .OneOf({"auto", "left", "right"})
      .ShowDefault();
  omnid
      .Add("--exit-idle", options.exit_idle_s,
           "end after this many seconds without a client (default: never; 60 when systemd has passed the socket)")
      .Positive();
  omnid.Add("--log-level", options.log_level, "lowest level that is logged")
      .OneOf({"trace", "debug", "info", "warn", "error", "off"})
      .ShowDefault();
  omnid.Add("!--no-realtime", options.realtime, "do not request SCHED_FIFO and mlockall");
}

}  // namespace omni::daemon
