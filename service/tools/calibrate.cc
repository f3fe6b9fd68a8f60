// omni calibrate: guides a person through a self-calibration and writes calibration.toml. With the twin a scripted hand
// of the simulation does what the person would, in virtual time.
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "service/base/whole_file.h"
#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/paths.h"
#include "service/config/twin_file.h"
#include "service/daemon/check_options.h"
#include "service/daemon/open_device.h"
#include "service/magnetics/nominal.h"
#include "service/sim/twin.h"
#include "service/tools/calibrate_device.h"
#include "service/tools/calibrate_kept.h"
#include "service/tools/calibrate_session.h"
#include "service/tools/calibrate_text.h"
#include "service/tools/calibrate_twin.h"
#include "service/tools/calibrate_zero.h"
#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/terminal.h"

namespace omni::tools {
namespace {

constexpr int kBarWidth = 30;
constexpr const char* kCalibrate = "omni calibrate";

struct Arguments {
  daemon::RunOptions run;  // which device
  std::string output;
  bool replace = false;
  bool restore = false;
  bool zero = false;
  SessionOptions session;
};

// On a terminal one line that changes, else a line per step.
class Display {
 public:
  explicit Display(const SessionOptions& options) : options_(options), live_(CanDraw()) {}

  void Show(const CalibrationSession& session) {
    if (session.step() != step_ || first_) {
      if (live_ && !first_) {
        Draw(session, 1);
        std::printf("\n");
      }
      std::printf("%s\n", StepText(session.step(), options_).c_str());
      step_ = session.step();
      percent_ = -1;
      first_ = false;
    }
    const int percent = static_cast<int>(100 * session.progress());
    if (!live_ || percent == percent_ || step_ == CalibrationStep::kDone) return;
    percent_ = percent;
    Draw(session, session.progress());
  }

 private:
  void Draw(const CalibrationSession& session, double progress) const {
    std::printf("\r     %s", ProgressBar(progress, kBarWidth).c_str());
    if (step_ == CalibrationStep::kWave || step_ == CalibrationStep::kTouch) {
      std::printf("  top %s rim", CoverageText(session.coverage()).c_str());
    }
    std::fflush(stdout);
  }

  SessionOptions options_;
  bool live_;
  bool first_ = true;
  CalibrationStep step_ = CalibrationStep::kClear;
  int percent_ = -1;
};

// Asked before anybody waves a pen for two minutes; empty: the result can be kept.
std::string PlaceProblem(const std::string& output, bool replace) {
  const int error = base::TryWholeFile(output, {.replace = replace, .make_folder = true});
  if (error == EEXIST) {
    return output + ": is there already; --replace measures this base again and keeps that file as " +
           config::PreviousCalibration(output) + ", or name another file: -o FILE";
  }
  return error == 0 ? std::string() : base::WriteProblem(output, error);
}

int Restore(const std::string& output, const config::ExpectedBase& of) {
  const base::Status restored = config::RestoreCalibrationFile(output, of);
  if (!restored.ok()) return Fail(kCalibrate, restored.error());
  std::printf("restored     %s from %s; omnid uses it from its next start\n", output.c_str(),
              config::PreviousCalibration(output).c_str());
  return kExitOk;
}

struct Measured {
  std::string serial;
  calibration::Outcome outcome;
};

base::Result<Measured> MeasureTwin(const Arguments& arguments, const base::DeviceGeometry& device,
                                   const SessionObserver& observer) {
  const std::uint64_t seed = arguments.run.twin_seed;
  const base::Result<base::TruthParameters> truth = config::FindTwin(arguments.run.twin);
  if (!truth.ok()) return base::Error{truth.error()};
  std::printf("device       digital twin (a simulation, its hand is a script), seed %llu, virtual time\n",
              static_cast<unsigned long long>(seed));
  auto done = CalibrateTwin(device, seed, *truth, arguments.session, observer);
  if (!done.ok()) return base::Error{done.error()};
  return Measured{"twin-" + std::to_string(seed), std::move(done->outcome)};
}

base::Result<Measured> MeasureBase(const Arguments& arguments, const base::DeviceGeometry& device,
                                   const SessionObserver& observer) {
  base::Result<daemon::OpenedDevice> opened = daemon::OpenDevice(arguments.run);
  if (!opened.ok()) return base::Error{opened.error()};
  const device::TransportInfo& info = opened->transport->info();
  std::printf("device       %s, serial %s%s\n", info.name.c_str(), opened->serial.c_str(),
              info.simulation ? " (a simulation)" : "");
  CalibrationSession session(device, arguments.session);
  if (const base::Status ran = RunSession(*opened->transport, session, [&] { observer(session); }); !ran.ok()) {
    return base::Error{ran.error()};
  }
  auto outcome = session.Finish();
  if (!outcome.ok()) return base::Error{outcome.error()};
  return Measured{opened->serial, std::move(*outcome)};
}

int Measure(const Arguments& arguments, const std::string& output, config::ExpectedBase of) {
  if (const std::string problem = PlaceProblem(output, arguments.replace); !problem.empty()) {
    return Fail(kCalibrate, problem);
  }
  const EndSignals signals;
  Display display(arguments.session);
  const auto measure = daemon::IsTwin(arguments.run.device) ? MeasureTwin : MeasureBase;
  const auto done = measure(arguments, of.device, [&](const CalibrationSession& session) { display.Show(session); });
  if (!done.ok()) return Fail(kCalibrate, done.error());
  of.serial = done->serial;
  std::printf("%s", ReportText(done->outcome.report).c_str());
  const base::Status saved =
      config::SaveCalibrationFile(output, CalibrationFileOf(done->outcome, of.serial), of, arguments.replace);
  if (!saved.ok()) return Fail(kCalibrate, saved.error());
  std::printf("written      %s; omnid uses it from its next start\n", output.c_str());
  return kExitOk;
}

constexpr double kTwinZero_s = 10;  // more than it takes

// The twin's pen is nowhere.
base::Result<daemon::OpenedDevice> OpenForZero(const Arguments& arguments, const base::DeviceGeometry& device) {
  if (!daemon::IsTwin(arguments.run.device)) return daemon::OpenDevice(arguments.run);
  const base::Result<base::TruthParameters> truth = config::FindTwin(arguments.run.twin);
  if (!truth.ok()) return base::Error{truth.error()};
  daemon::OpenedDevice opened;
  opened.transport = sim::MakeVirtualTwin(device, {.seed = arguments.run.twin_seed, .truth = *truth}, kTwinZero_s);
  opened.serial = "twin-" + std::to_string(arguments.run.twin_seed);
  return opened;
}

// What the sensors read without a pen, again; everything else of the file stays.
int Zero(const Arguments& arguments, const std::string& output, config::ExpectedBase of) {
  if (const std::string problem = PlaceProblem(output, true); !problem.empty()) return Fail(kCalibrate, problem);
  auto file = config::LoadCalibrationFile(output, of);
  if (!file.ok()) return Fail(kCalibrate, file.error() + "; --zero changes a calibration that is there");
  const EndSignals signals;
  auto opened = OpenForZero(arguments, of.device);
  if (!opened.ok()) return Fail(kCalibrate, opened.error());
  of.serial = opened->serial;
  if (file = config::LoadCalibrationFile(output, of); !file.ok()) return Fail(kCalibrate, file.error());
  ZeroSession session(file->calibration);
  std::printf("%s\n", session.Instruction().c_str());
  if (const base::Status ran = RunSession(*opened->transport, session, {}); !ran.ok()) {
    return Fail(kCalibrate, ran.error());
  }
  const base::Result<calibration::Zeroed> zeroed = session.Finish();
  if (!zeroed.ok()) return Fail(kCalibrate, zeroed.error());
  file->calibration = zeroed->calibration;
  const base::Status saved = config::SaveCalibrationFile(output, *file, of, true);
  if (!saved.ok()) return Fail(kCalibrate, saved.error());
  std::printf("zeroed       the field had changed by %.1f uT, sensors by themselves by up to %.1f uT\n",
              1e6 * zeroed->uniform_T, 1e6 * zeroed->own_T);
  std::printf("written      %s; omnid uses it from its next start\n", output.c_str());
  return kExitOk;
}

int Calibrate(const Arguments& arguments) {
  if (const std::string problem = daemon::TwinChoiceProblem(arguments.run); !problem.empty()) {
    return Refuse(kCalibrate, problem);
  }
  base::DeviceGeometry device = config::DefaultDevice();
  if (!arguments.run.device_file.empty()) {
    auto loaded = config::LoadDeviceFile(arguments.run.device_file);
    if (!loaded.ok()) return Fail(kCalibrate, loaded.error());
    device = *loaded;
  }
  const std::string output = arguments.output.empty() ? config::UserCalibrationFile() : arguments.output;
  if (output.empty()) return Fail(kCalibrate, "no home folder to write calibration.toml to; name a file with -o FILE");
  const config::ExpectedBase of{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}};
  if (arguments.restore) return Restore(output, of);
  return arguments.zero ? Zero(arguments, output, of) : Measure(arguments, output, of);
}

}  // namespace

void AddCalibrate(Command& app) {
  auto arguments = std::make_shared<Arguments>();
  Command calibrate = app.AddCommand("calibrate", "measure this base: sweep, wave, touch; writes calibration.toml");
  calibrate.Add("--device", arguments->run.device, daemon::DeviceHelp())
      .Check("DEVICE", daemon::DeviceProblem)
      .ShowDefault();
  calibrate.Add("--device-file", arguments->run.device_file, "geometry (default: the built-in omni.toml)");
  calibrate.Add("--seed", arguments->run.twin_seed, "of the twin: the same base as `omnid --twin-seed`").ShowDefault();
  const Option twin = calibrate.Add("--twin", arguments->run.twin, config::kTwinHelp);
  calibrate.AddShort("--ideal", arguments->run.twin, config::kIdeal, config::kIdealHelp).Excludes(twin);
  calibrate.Add("--output,-o", arguments->output, "default: $XDG_CONFIG_HOME/omni/calibration.toml");
  Option replace = calibrate.Add("--replace", arguments->replace,
                                 "measure again; the file that is there is kept as calibration.previous.toml");
  Option restore =
      calibrate
          .Add("--restore", arguments->restore, "take the previous file back; it and the present one change places")
          .Excludes(replace);
  calibrate.Add("--zero", arguments->zero, "two seconds: measure again only what the sensors read without the pen")
      .Excludes(replace)
      .Excludes(restore);
  calibrate.Add("--wave-seconds", arguments->session.wave_s, "how long to wave the pen").Range(3.0, 60.0).ShowDefault();
  calibrate.Add("--touches", arguments->session.touches, "how many places to touch").Range(20, 150).ShowDefault();
  calibrate.Run(arguments, Calibrate);
}

}  // namespace omni::tools
