#include "service/tools/setup/setup.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "service/base/files/whole_file.h"
#include "service/config/paths.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;
using enum StepOutcome::Kind;

constexpr double kPatience_s = 90;
constexpr double kFelt_N = 0.2;

StepOutcome Done(std::string text) { return {kDone, std::move(text)}; }
StepOutcome Skipped(std::string text) { return {kSkipped, std::move(text)}; }
StepOutcome Failed(std::string text) { return {kFailed, std::move(text)}; }

bool Exists(const std::string& path) {
  std::error_code error;
  return !path.empty() && fs::exists(path, error);
}

// Of a command that prints itself what is wrong and what to do.
StepOutcome OfStatus(int status, std::string done, std::string failed) {
  return status == kExitOk ? Done(std::move(done)) : Failed(std::move(failed));
}

StepOutcome FindDevice(SetupRun& run) {
  if (run.rehearsal()) return Done("a rehearsal: base, pen and hand are simulated by the digital twin");
  const base::Result<std::string> found = FindUsbBase();
  return found.ok() ? Done(*found) : Failed(found.error());
}

StepOutcome SelfTest(SetupRun& run) {
  if (run.rehearsal()) return Skipped("a simulated base has nothing to test");
  if (!run.Ask("The test arms the base for a moment, without current in its coils. Go on?")) {
    return Skipped("`omni device selftest` does it later");
  }
  run.EndService();  // the test needs the base for itself
  return OfStatus(run.Omni({"device", "selftest", "--yes"}), "the base passes its own test",
                  "the lines that begin with FAIL say what to do; docs/howto/build-a-base.md explains each");
}

StepOutcome Calibrate(SetupRun& run) {
  std::vector<std::string> words{"calibrate", "--device", run.device()};
  if (Exists(config::UserCalibrationFile())) {
    if (!run.Ask("This base may be calibrated already (" + config::UserCalibrationFile() + "). Measure it again?")) {
      return Done("the calibration that is there is kept");
    }
    words.emplace_back("--replace");
  }
  run.EndService();
  return OfStatus(run.Omni(words), "calibrated: " + config::UserCalibrationFile(),
                  "nothing was changed. Take other magnets and steel away from the base, and try again");
}

StepOutcome UndoCalibrate(SetupRun& run) {
  const fs::path file = config::UserCalibrationFile();
  const fs::path previous = file.parent_path() / "calibration.previous.toml";
  if (Exists(previous.string())) {
    return OfStatus(run.Omni({"calibrate", "--restore"}), "the calibration of before is back", "see above");
  }
  std::error_code error;
  if (!fs::remove(file, error)) return Skipped("there is no calibration");
  return Done("removed " + file.string() + ": the nominal geometry is used, with less force");
}

StepOutcome Align(SetupRun& run) {
  const base::Status service = run.NeedService();
  if (!service.ok()) return Failed(service.error());
  std::vector<std::string> words{"align", "touch"};
  if (run.rehearsal()) {
    const std::string probe = run.folder() + "/controller";
    const base::Status written = base::WriteWholeFile(
        probe, "#!/bin/sh\nexec '" + config::ProgramFolder() + "/omni' rehearse-controller\n", {.mode = 0700});
    if (!written.ok()) return Failed(written.error());
    words.insert(words.end(), {"--probe", probe});
  } else if (!run.Ask("Headset and controllers are on, and its OpenXR runtime runs on this computer?")) {
    return Skipped(
        "until then the base is assumed 45 cm in front of you and 35 cm below your eyes; `omni align` does it");
  }
  return OfStatus(run.Omni(words), "the base's place in the headset's space is stored",
                  "nothing was stored; docs/howto/align.md lists other methods");
}

StepOutcome UndoAlign(SetupRun& run) {
  const base::Status service = run.NeedService();
  if (!service.ok()) return Failed(service.error());
  return OfStatus(run.Omni({"align", "--forget"}), "all alignments are deleted", "see above");
}

// The hand that holds the pen, and how hard it presses: a file of ours is replaced, another one is the user's.
StepOutcome SetInputs(SetupRun& run) {
  const base::Status service = run.NeedService();
  if (!service.ok()) return Failed(service.error());
  const std::string hand = run.Choose("Which hand holds the pen?", {"right", "left"}, "right");
  Print("Press the tip onto the clay above the base a few times, as hard as you like to write.\n");
  const base::Result<Felt> felt =
      FeelScene(run, "extrusion", kPatience_s, [](const Felt& now) { return now.presses >= 3; });
  if (!felt.ok()) return Failed(felt.error());
  const double full_N = std::clamp(0.8 * felt->largest_force_N, 0.3, 1.5);
  const std::string text = std::string(kWrittenBySetup) + "\nhand = \"" + hand +
                           "\"\n\n[inputs]\ntip_force_full_N = " + Format("%.2f", full_N) +
                           "   # of the tip's pressure 1; you pressed with " + Format("%.2f", felt->largest_force_N) +
                           " N\n";
  const std::string path = config::UserInputsFile();
  if (WhoseInputs(path) == Inputs::kOfTheUser) {
    return Skipped(path + " is yours and stays as it is. These lines would go into it:\n" + text);
  }
  const base::Status written = base::WriteWholeFile(path, text, {.make_folder = true});
  if (!written.ok()) return Failed(written.error());
  run.EndService();  // it reads the file at its start
  return Done(std::to_string(felt->presses) + " presses, at most " + Format("%.2f", felt->largest_force_N) +
              " N: " + path + ". Double tap, flick and long presses are buttons too: docs/howto/apps.md");
}

StepOutcome UndoInputs(SetupRun& /*run*/) {
  const std::string path = config::UserInputsFile();
  const Inputs whose = WhoseInputs(path);
  if (whose == Inputs::kNone) return Skipped("there is no " + path);
  if (whose == Inputs::kOfTheUser) return Failed(path + " is not of omni setup; edit it yourself");
  std::error_code error;
  fs::remove(path, error);
  return error ? Failed(path + ": " + error.message()) : Done("removed " + path);
}

StepOutcome EnableLayer(SetupRun& run) {
  if (!run.Ask("Give the pen to every OpenXR application of yours? Without it, those that request the layer get it.")) {
    return Skipped("`omni layer enable` does it later");
  }
  return OfStatus(run.Omni({"layer", "enable"}), "applications get the pen from their next start", "see above");
}

StepOutcome UndoLayer(SetupRun& run) {
  return OfStatus(run.Omni({"layer", "disable"}), "applications no longer get the layer by themselves", "see above");
}

StepOutcome FeelScenes(SetupRun& run) {
  struct Row {
    const char* scene;
    const char* what;
  };
  constexpr Row kRows[] = {{"extrusion", "clay: press on a face until it takes hold, then pull"},
                           {"dragon", "a soft dragon: press, and it gives way"},
                           {"racetrack", "a car: lean the pen to steer, and feel the walls"}};
  const base::Status service = run.NeedService();
  if (!service.ok()) return Failed(service.error());
  std::string text;
  for (const Row& row : kRows) {
    Print(std::string("Now ") + row.what + ".\n");
    const base::Result<Felt> felt =
        FeelScene(run, row.scene, kPatience_s, [](const Felt& now) { return now.largest_force_N >= kFelt_N; });
    if (!felt.ok()) return Failed(std::string(row.scene) + ": " + felt.error());
    Print(std::string("  felt ") + Format("%.2f", felt->largest_force_N) + " N\n");
    text += (text.empty() ? "" : ", ") + std::string(row.scene) + " " + Format("%.2f", felt->largest_force_N) + " N";
  }
  return Done("largest forces: " + text);
}

bool HasUserManager() { return std::system("systemctl --user cat omnid.socket >/dev/null 2>&1") == 0; }

StepOutcome StartWithSession(SetupRun& run) {
  if (run.rehearsal()) return Skipped("a rehearsal starts nothing that stays");
  if (!HasUserManager()) {
    return Skipped("there is no systemd session with omnid.socket here: start `omnid` yourself before an application");
  }
  if (!run.Ask("Start omnid with the first application of each session, and end it when nobody needs it?")) {
    return Skipped("`systemctl --user enable --now omnid.socket` does it later");
  }
  run.EndService();
  return std::system("systemctl --user enable --now omnid.socket") == 0
             ? Done("omnid starts when it is needed")
             : Failed("systemctl says why; `systemctl --user start omnid` starts it now");
}

StepOutcome UndoStart(SetupRun& /*run*/) {
  if (!HasUserManager()) return Skipped("there is no systemd session with omnid.socket here");
  return std::system("systemctl --user disable --now omnid.socket") == 0 ? Done("omnid no longer starts by itself")
                                                                         : Failed("systemctl says why");
}

constexpr SetupStep kSteps[] = {
    {"device", "Find the base", "The base is connected by USB and has its own supply.", "a second", FindDevice, nullptr,
     DeviceState},
    {"selftest", "Test the base", "Sensors, supply, fan and coils, armed for a moment without current.", "five seconds",
     SelfTest, nullptr, nullptr},
    {"calibrate", "Calibrate the base",
     "No base is quite as it was designed. Keep the pen away first, then wave it, then touch the hull, as the lines "
     "say. "
     "With it the pen is tracked to a fifth of a millimetre and the full force may be used.",
     "two minutes", Calibrate, UndoCalibrate, CalibrationState},
    {"align", "Align the base with your headset",
     "A controller touches five marks on the base, so that the pen is seen where it is.", "half a minute", Align,
     UndoAlign, AlignmentState},
    {"inputs", "Hand and pressure", "The hand that holds the pen, and how hard it presses for full pressure.",
     "half a minute", SetInputs, UndoInputs, InputsState},
    {"layer", "Give applications the pen", "OpenXR applications see the pen as a controller, by a layer.", "a second",
     EnableLayer, UndoLayer, LayerState},
    {"scenes", "Feel three scenes", "Clay, a soft dragon, a race.", "a minute", FeelScenes, nullptr, nullptr},
    {"start", "Start with your session", "systemd starts omnid with the first application.", "a second",
     StartWithSession, UndoStart, StartState},
};

}  // namespace

std::span<const SetupStep> SetupSteps() { return kSteps; }

nlohmann::json SetupStepRows(const nlohmann::json& status) {
  constexpr const char* kStates[] = {"done", "open", "unknown"};
  nlohmann::json rows = nlohmann::json::array();
  for (const SetupStep& step : SetupSteps()) {
    const StepState state = step.state == nullptr ? StepState{} : step.state(status);
    rows.push_back({{"name", step.name},
                    {"title", step.title},
                    {"about", step.about},
                    {"takes", step.takes},
                    {"command", std::string("omni setup ") + step.name},
                    {"can_be_undone", step.undo != nullptr},
                    {"state", kStates[static_cast<int>(state.kind)]},
                    {"text", state.text}});
  }
  return rows;
}

const SetupStep* FindSetupStep(const std::string& name) {
  const auto found =
      std::find_if(std::begin(kSteps), std::end(kSteps), [&](const SetupStep& s) { return s.name == name; });
  return found == std::end(kSteps) ? nullptr : found;
}

}  // namespace omni::tools
