// omni calibrate: guides a person through a self-calibration and writes calibration.toml. With the twin, a scripted
// hand of the simulation acts as the person, in virtual time.
#include <cerrno>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "service/base/files/whole_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/config/paths.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/run.h"
#include "service/magnetics/nominal.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_session.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

constexpr int kBarWidth = 30;
constexpr const char* kCalibrate = "omni calibrate";

struct Arguments {
  daemon::RunOptions run;  // which device
  std::string output;
  bool replace = false;
  bool restore = false;
  int back = 1;
  bool zero = false;
  bool tip = false;
  SessionOptions session;
};

// On a terminal one line that is updated, otherwise one line per step.
class Display {
 public:
  // `beside`: text beside the bar of a step.
  void Show(const GuidedSession& session, const std::function<std::string(int step)>& beside = {}) {
    const bool next = session.step_number() != step_;
    if (live_ && step_ != kNone && (next || session.done())) {
      Draw(1, beside);
      std::printf("\n");
    }
    if (next) {
      std::printf("%s\n", session.Instruction().c_str());
      step_ = session.step_number();
      percent_ = -1;
      left_ = {};
    }
    const int percent = static_cast<int>(100 * session.progress());
    if (!live_ || percent == percent_ || session.done()) return;
    percent_ = percent;
    Draw(session.progress(), beside);
  }

 private:
  static constexpr int kNone = -1;

  void Draw(double progress, const std::function<std::string(int step)>& beside) {
    const std::string left = left_.Text(progress);
    std::printf("\r\033[K     %s%s%s", ProgressBar(progress, kBarWidth).c_str(), beside ? beside(step_).c_str() : "",
                left.c_str());
    std::fflush(stdout);
  }

  bool live_ = CanDraw();
  int step_ = kNone;
  int percent_ = -1;
  TimeLeft left_;
};

// The hemisphere while the pen goes round it.
void ShowCoverage(Display& display, const CalibrationSession& session) {
  display.Show(session, [&](int step) {
    const bool round =
        step == static_cast<int>(CalibrationStep::kWave) || step == static_cast<int>(CalibrationStep::kTouch);
    return round ? "  top " + CoverageText(session.coverage()) + " rim" : std::string();
  });
}

// Checked before the person waves a pen for two minutes; empty: the result can be written.
std::string PlaceProblem(const std::string& output, bool replace) {
  const int error = base::TryWholeFile(output, {.replace = replace, .make_folder = true});
  if (error == EEXIST) {
    return output + ": already exists; --replace measures this base again and keeps that file as " +
           config::PreviousCalibration(output) + ", or choose another file: -o FILE";
  }
  return error == 0 ? std::string() : base::WriteProblem(output, error);
}

int Restore(const std::string& output, const config::ExpectedBase& of, int number) {
  const base::Status restored = config::RestoreCalibrationFile(output, of, number);
  if (!restored.ok()) return Fail(kCalibrate, restored.error());
  std::printf("restored     %s from %s; omnid uses it from its next start\n", output.c_str(),
              config::PreviousCalibration(output, number).c_str());
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
  std::printf("device       digital twin (a simulation with a scripted hand), seed %llu, virtual time\n",
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

// The pen is the same as in the replaced file.
void KeepTip(const std::string& output, const config::ExpectedBase& of, config::CalibrationFile& file) {
  const auto before = config::LoadCalibrationFile(output, of);
  if (!before.ok() || !before->tip_measured) return;
  file.tip_measured = true;
  file.calibration.magnet.tip_offset_m = before->calibration.magnet.tip_offset_m;
  std::printf("tip          %.2f mm from the magnet's centre, as before; for another pen: omni calibrate --tip\n",
              1e3 * file.calibration.magnet.tip_offset_m);
}

int Measure(const Arguments& arguments, const std::string& output, config::ExpectedBase of) {
  if (const std::string problem = PlaceProblem(output, arguments.replace); !problem.empty()) {
    return Fail(kCalibrate, problem);
  }
  const EndSignals signals;
  Display display;
  const auto measure = daemon::IsTwin(arguments.run.device) ? MeasureTwin : MeasureBase;
  const auto done =
      measure(arguments, of.device, [&](const CalibrationSession& session) { ShowCoverage(display, session); });
  if (!done.ok()) return Fail(kCalibrate, done.error());
  of.serial = done->serial;
  std::printf("%s", ReportText(done->outcome.report).c_str());
  config::CalibrationFile file = CalibrationFileOf(done->outcome, of.serial);
  KeepTip(output, of, file);
  const base::Status saved = config::SaveCalibrationFile(output, file, of, arguments.replace);
  if (!saved.ok()) return Fail(kCalibrate, saved.error());
  std::printf("written      %s; omnid uses it from its next start\n", output.c_str());
  return kExitOk;
}

constexpr double kTwinChange_s = 60;  // longer than needed

// `hand`: script of the twin's hand.
base::Result<daemon::OpenedDevice> OpenForChange(const Arguments& arguments, const base::DeviceGeometry& device,
                                                 const sim::HandScript& hand) {
  if (!daemon::IsTwin(arguments.run.device)) return daemon::OpenDevice(arguments.run);
  const base::Result<base::TruthParameters> truth = config::FindTwin(arguments.run.twin);
  if (!truth.ok()) return base::Error{truth.error()};
  daemon::OpenedDevice opened;
  const sim::TwinOptions twin{.seed = arguments.run.twin_seed, .script = hand, .truth = *truth};
  opened.transport = sim::MakeVirtualTwin(device, twin, kTwinChange_s);
  opened.serial = "twin-" + std::to_string(arguments.run.twin_seed);
  return opened;
}

// What an option measures again in an existing calibration; the rest of the file is kept.
template <class Session>
struct Change {
  const char* option = "";
  sim::HandScript hand;
  std::function<Session(const base::Calibration&)> begin;
  // Writes the result into the file; returns its text.
  std::function<base::Result<std::string>(const Session&, config::CalibrationFile&)> finish;
};

template <class Session>
int Apply(const Change<Session>& change, const Arguments& arguments, const std::string& output,
          config::ExpectedBase of) {
  if (const std::string problem = PlaceProblem(output, true); !problem.empty()) return Fail(kCalibrate, problem);
  auto file = config::LoadCalibrationFile(output, of);
  if (!file.ok()) return Fail(kCalibrate, file.error() + "; " + change.option + " needs an existing calibration");
  const EndSignals signals;
  auto opened = OpenForChange(arguments, of.device, change.hand);
  if (!opened.ok()) return Fail(kCalibrate, opened.error());
  of.serial = opened->serial;
  if (file = config::LoadCalibrationFile(output, of); !file.ok()) return Fail(kCalibrate, file.error());
  Session session = change.begin(file->calibration);
  Display display;
  display.Show(session);
  const base::Status ran = RunSession(*opened->transport, session, [&] { display.Show(session); });
  if (!ran.ok()) return Fail(kCalibrate, ran.error());
  const base::Result<std::string> found = change.finish(session, *file);
  if (!found.ok()) return Fail(kCalibrate, found.error());
  const base::Status saved = config::SaveCalibrationFile(output, *file, of, true);
  if (!saved.ok()) return Fail(kCalibrate, saved.error());
  std::printf("%s\nwritten      %s; omnid uses it from its next start\n", found->c_str(), output.c_str());
  return kExitOk;
}

// What the sensors read without a pen.
Change<ZeroSession> ZeroChange() {
  return {.option = "--zero",
          .hand = {},
          .begin = [](const base::Calibration& before) { return ZeroSession(before); },
          .finish = [](const ZeroSession& session, config::CalibrationFile& file) -> base::Result<std::string> {
            const base::Result<calibration::Zeroed> zeroed = session.Finish();
            if (!zeroed.ok()) return base::Error{zeroed.error()};
            file.calibration = zeroed->calibration;
            return ZeroText(*zeroed);
          }};
}

// Where the pen's tip is.
Change<TipSession> TipChange(double drawn_m, std::uint64_t twin_seed) {
  return {.option = "--tip",
          .hand = MakePivotingHand({.seed = twin_seed + 1}),
          .begin = [drawn_m](const base::Calibration& before) { return TipSession(before, drawn_m); },
          .finish = [drawn_m](const TipSession& session, config::CalibrationFile& file) -> base::Result<std::string> {
            const base::Result<calibration::Tip> tip = session.Finish();
            if (!tip.ok()) return base::Error{tip.error()};
            file.tip_measured = true;
            file.calibration.magnet.tip_offset_m = tip->tip_offset_m;
            return TipText(*tip, drawn_m);
          }};
}

int Calibrate(const Arguments& arguments) {
  if (const std::string problem = daemon::TwinChoiceProblem(arguments.run); !problem.empty()) {
    return FailUsage(kCalibrate, problem);
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
  if (arguments.restore) return Restore(output, of, arguments.back);
  if (arguments.zero) return Apply(ZeroChange(), arguments, output, of);
  if (arguments.tip) {
    return Apply(TipChange(device.magnet.tip_offset_m, arguments.run.twin_seed), arguments, output, of);
  }
  return Measure(arguments, output, of);
}

}  // namespace

void AddCalibrate(Command& app) {
  auto arguments = std::make_shared<Arguments>();
  Command calibrate = app.AddCommand("calibrate", "calibrate this base: sweep, wave, touch; writes calibration.toml");
  calibrate.Add("--device", arguments->run.device, daemon::DeviceHelp())
      .Check("DEVICE", daemon::DeviceProblem)
      .ShowDefault();
  calibrate.Add("--device-file", arguments->run.device_file, "geometry (default: the built-in omni.toml)");
  calibrate.Add("--seed", arguments->run.twin_seed, "of the twin: the same base as `omnid --twin-seed`").ShowDefault();
  const Option twin = calibrate.Add("--twin", arguments->run.twin, config::kTwinHelp);
  calibrate.AddShort("--ideal", arguments->run.twin, config::kIdeal, config::kIdealHelp).Excludes(twin);
  calibrate.Add("--output,-o", arguments->output, "default: $XDG_CONFIG_HOME/omni/calibration.toml");
  Option replace = calibrate.Add("--replace", arguments->replace,
                                 "calibrate again; the existing file is kept as calibration.previous.toml");
  Option restore =
      calibrate.Add("--restore", arguments->restore, "swap the previous calibration file with the current one")
          .Excludes(replace);
  calibrate.Add("--back", arguments->back, "with --restore: the last one is 1, the one before it 2")
      .Range(1, config::kPreviousCalibrations)
      .Needs(restore);
  Option zero =
      calibrate.Add("--zero", arguments->zero, "measure again only what the sensors read without the pen (two seconds)")
          .Excludes(replace)
          .Excludes(restore);
  calibrate
      .Add("--tip", arguments->tip, "measure only where the pen's tip is, by tilting the pen about it (ten seconds)")
      .Excludes(replace)
      .Excludes(restore)
      .Excludes(zero);
  calibrate.Add("--wave-seconds", arguments->session.wave_s, "how long to wave the pen").Range(3.0, 60.0).ShowDefault();
  calibrate.Add("--touches", arguments->session.touches, "how many places to touch").Range(20, 150).ShowDefault();
  calibrate.SetAction(arguments, Calibrate);
}

}  // namespace omni::tools
