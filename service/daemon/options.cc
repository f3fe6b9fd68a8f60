#include "service/daemon/run.h"

#include "service/base/files/whole_file.h"
#include "service/config/files/alignment_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/console/command.h"
#include "service/daemon/devices/open_device.h"
#include "service/magnetics/nominal.h"
#include "service/sim/hand/hand.h"

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
  omnid.Add("--builder", options.builder_program, "program that builds scenes (default: omni-builder beside omnid)");
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

namespace {

template <class T>
std::string ErrorOf(const base::Result<T>& result) {
  return result.ok() ? std::string() : result.error();
}

std::string ScriptProblem(const std::string& path) { return ErrorOf(sim::LoadHandScript(path)); }
std::string TwinProblem(const std::string& name_or_file) { return ErrorOf(config::FindTwin(name_or_file)); }
std::string AlignmentsProblem(const std::string& path) { return ErrorOf(config::LoadAlignmentFile(path)); }
std::string DeviceFileProblem(const std::string& path) { return ErrorOf(config::LoadDeviceFile(path)); }

struct FileOption {
  const char* name;
  std::string RunOptions::*path;
  std::string (*problem)(const std::string& path);
};
constexpr FileOption kFileOptions[] = {
    {"--device-file", &RunOptions::device_file, DeviceFileProblem},
    {"--alignments", &RunOptions::alignment_path, AlignmentsProblem},
    {"--twin", &RunOptions::twin, TwinProblem},
    {"--twin-script", &RunOptions::twin_script, ScriptProblem},
};

struct Recorded {
  const char* name;
  std::string RunOptions::*path;
};
constexpr Recorded kRecorded[] = {
    {"--record", &RunOptions::record_path},
    {"--record-device", &RunOptions::record_device_path},
    {"--twin-record", &RunOptions::twin_record},
};

// Precondition: the device's file can be read, if one is given.
std::string CalibrationProblem(const RunOptions& options) {
  if (options.calibration_path.empty()) return {};
  const base::DeviceGeometry device =
      options.device_file.empty() ? config::DefaultDevice() : *config::LoadDeviceFile(options.device_file);
  const config::ExpectedBase expected{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}};
  const std::string problem = ErrorOf(config::LoadCalibrationFile(options.calibration_path, expected));
  return problem.empty() ? problem : "--calibration: " + problem;
}

}  // namespace

std::string TwinChoiceProblem(const RunOptions& options) {
  if (options.twin.empty() || IsTwin(options.device)) return {};
  return "--twin, --ideal: need --device twin";
}

std::string OptionsProblem(const RunOptions& options) {
  const bool twin = IsTwin(options.device);
  if (const std::string problem = TwinChoiceProblem(options); !problem.empty()) return problem;
  if (!twin && !options.twin_script.empty()) return "--twin-script: needs --device twin";
  if (!twin && !options.twin_hand.empty()) return "--twin-hand: needs --device twin";
  if (!twin && !options.twin_record.empty()) return "--twin-record: needs --device twin";
  for (const FileOption& option : kFileOptions) {
    const std::string& path = options.*option.path;
    const std::string problem = path.empty() ? std::string() : option.problem(path);
    if (!problem.empty()) return option.name + (": " + problem);
  }
  for (const Recorded& recorded : kRecorded) {
    const std::string& path = options.*recorded.path;
    const std::string problem = path.empty() ? std::string() : base::NewFileProblem(path, options.replace);
    if (!problem.empty()) return recorded.name + (": " + problem);
  }
  return CalibrationProblem(options);
}

base::Status MakeWay(const RunOptions& options) {
  if (!options.replace) return base::Ok{};
  for (const Recorded& recorded : kRecorded) {
    const base::Status removed = base::RemoveForNew(options.*recorded.path);
    if (!removed.ok()) return removed;
  }
  return base::Ok{};
}

RunOptions WithFreeNames(RunOptions options) {
  for (const Recorded& recorded : kRecorded) {
    std::string& path = options.*recorded.path;
    if (!path.empty()) path = base::FreeName(path);
  }
  return options;
}

}  // namespace omni::daemon
