// omni calibrate: guides a person through a self-calibration and writes calibration.toml. With the twin a scripted hand
// of the simulation does what the person would.
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>

#include "service/base/whole_file.h"
#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/paths.h"
#include "service/config/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/tools/calibrate_session.h"
#include "service/tools/calibrate_text.h"
#include "service/tools/calibrate_twin.h"
#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/terminal.h"

namespace omni::tools {
namespace {

constexpr int kBarWidth = 30;
constexpr const char* kCalibrate = "omni calibrate";

struct Arguments {
  std::string device = "twin";
  std::string device_file;
  std::string output;
  bool replace = false;
  bool restore = false;
  std::uint64_t seed = 1;
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

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

config::CalibrationFile ToFile(const calibration::Outcome& outcome, const std::string& serial) {
  const calibration::Report& report = outcome.report;
  return {.calibration = outcome.calibration,
          .serial = serial,
          .date = Now(),
          .quality = {.expected_error_mm = 1e3 * report.expected_error_m,
                      .frame_rotation_deg = 57.29577951308232 * report.frame_rotation_rad,
                      .chi2_per_dof = report.chi2_per_dof,
                      .coverage = report.coverage,
                      .samples = report.samples,
                      .touches = report.touches,
                      .unfixed = static_cast<int>(report.unfixed.size())}};
}

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

int Measure(const Arguments& arguments, const std::string& output, config::ExpectedBase of) {
  if (const std::string problem = PlaceProblem(output, arguments.replace); !problem.empty()) {
    return Fail(kCalibrate, problem);
  }
  of.serial = "twin-" + std::to_string(arguments.seed);
  std::printf("device       digital twin (a simulation, its hand is a script), seed %llu, virtual time\n",
              static_cast<unsigned long long>(arguments.seed));
  Display display(arguments.session);
  const auto done = CalibrateTwin(of.device, arguments.seed, config::DefaultTwin(), arguments.session,
                                  [&](const CalibrationSession& session) { display.Show(session); });
  if (!done.ok()) return Fail(kCalibrate, done.error());
  const calibration::Outcome& outcome = done->outcome;
  std::printf("%s", ReportText(outcome.report).c_str());
  const base::Status saved = config::SaveCalibrationFile(output, ToFile(outcome, of.serial), of, arguments.replace);
  if (!saved.ok()) return Fail(kCalibrate, saved.error());
  std::printf("written      %s; omnid uses it from its next start\n", output.c_str());
  return kExitOk;
}

int Calibrate(const Arguments& arguments) {
  base::DeviceGeometry device = config::DefaultDevice();
  if (!arguments.device_file.empty()) {
    auto loaded = config::LoadDeviceFile(arguments.device_file);
    if (!loaded.ok()) return Fail(kCalibrate, loaded.error());
    device = *loaded;
  }
  const std::string output = arguments.output.empty() ? config::UserCalibrationFile() : arguments.output;
  if (output.empty()) return Fail(kCalibrate, "no home folder to write calibration.toml to; name a file with -o FILE");
  const config::ExpectedBase of{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}};
  return arguments.restore ? Restore(output, of) : Measure(arguments, output, of);
}

}  // namespace

void AddCalibrate(Command& app) {
  auto arguments = std::make_shared<Arguments>();
  Command calibrate = app.AddCommand("calibrate", "measure this base: sweep, wave, touch; writes calibration.toml");
  calibrate.Add("--device", arguments->device, "twin: the digital twin (a simulation)").OneOf({"twin"}).ShowDefault();
  calibrate.Add("--device-file", arguments->device_file, "geometry (default: the built-in omni.toml)");
  calibrate.Add("--seed", arguments->seed, "of the twin: the same base as `omnid --twin-seed`").ShowDefault();
  calibrate.Add("--output,-o", arguments->output, "default: $XDG_CONFIG_HOME/omni/calibration.toml");
  Option replace = calibrate.Add("--replace", arguments->replace,
                                 "measure again; the file that is there is kept as calibration.previous.toml");
  calibrate.Add("--restore", arguments->restore, "take the previous file back; it and the present one change places")
      .Excludes(replace);
  calibrate.Add("--wave-seconds", arguments->session.wave_s, "how long to wave the pen").Range(3.0, 60.0).ShowDefault();
  calibrate.Add("--touches", arguments->session.touches, "how many places to touch").Range(20, 150).ShowDefault();
  calibrate.Run(arguments, Calibrate);
}

}  // namespace omni::tools
