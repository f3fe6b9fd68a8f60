// Parts of `omni setup`.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/tools/common/child_program.h"

namespace omni::tools {

// How far a base is set up, as omnid's status and the user's files show it.
struct StepState {
  enum class Kind { kDone, kOpen, kUnknown };  // kUnknown: nothing shows whether it was done
  Kind kind = Kind::kUnknown;
  std::string text;  // what is there, or what is missing
};

// Each: `status` is that of omnid (docs/protocol/ipc.md), null without one. Starts nothing, changes nothing.
StepState DeviceState(const nlohmann::json& status);
StepState CalibrationState(const nlohmann::json& status);
StepState AlignmentState(const nlohmann::json& status);
StepState InputsState(const nlohmann::json& status);
StepState LayerState(const nlohmann::json& status);
StepState StartState(const nlohmann::json& status);

// Serial number and port of the first base on USB. Error: none can be used, with what to do.
base::Result<std::string> FindUsbBase();

enum class Inputs { kNone, kOfSetup, kOfTheUser };
inline constexpr const char* kWrittenBySetup = "# Written by omni setup.";  // the first line of its inputs.toml

// Whose inputs.toml it is; an empty one is as good as none.
Inputs WhoseInputs(const std::string& path);

// What the steps of omni setup share: where their files go, the commands that they run, omnid, and the person's
// answers.
class SetupRun {
 public:
  // A rehearsal: the digital twin instead of a base, and all files in a folder of its own, which ends with it: nothing
  // of the user's is read or changed. `yes`: every question is answered with yes.
  static base::Result<std::unique_ptr<SetupRun>> Start(bool rehearsal, bool yes);

  bool rehearsal() const { return rehearsal_; }
  std::string device() const { return rehearsal_ ? "twin" : "usb"; }
  // For files of a rehearsal, and logs; only the user can enter it.
  const std::string& folder() const { return folder_.path(); }
  std::string hand_socket() const { return folder() + "/hand.sock"; }  // of the twin

  // False also at the end of the input.
  bool Ask(const std::string& question) const;
  // One of the answers; the first one with `yes` and for an empty line; `at_end` at the end of the input.
  std::string Choose(const std::string& question, const std::vector<std::string>& answers,
                     const std::string& at_end) const;

  // `omni WORDS`; its exit status.
  int Omni(const std::vector<std::string>& words) const;
  // In the background; its output goes to a file of folder().
  base::Result<ChildProgram> OmniBehind(const std::vector<std::string>& words) const;

  // An omnid with a device: the one that runs, else one of our own until the end.
  base::Status NeedService();
  // Of our own, so that it reads changed files; one that was running before is not ours to end.
  void EndService() { service_.reset(); }

 private:
  SetupRun(bool rehearsal, bool yes, PrivateFolder folder)
      : rehearsal_(rehearsal), yes_(yes), folder_(std::move(folder)) {}

  bool rehearsal_, yes_;
  PrivateFolder folder_;
  std::optional<ChildProgram> service_;  // ends before its folder
};

// omni setup: one row per step, from plugging in to feeling a force.
struct StepOutcome {
  enum class Kind { kDone, kSkipped, kFailed };
  Kind kind = Kind::kDone;
  std::string text;  // what was found; why it is skipped; what failed and what to do
};

struct SetupStep {
  const char* name;   // on the command line
  const char* title;  // what the person does
  const char* about;  // why, and what happens
  const char* takes;
  StepOutcome (*run)(SetupRun& run);
  // Takes back what the step has changed of the user's. Null: it changes nothing.
  StepOutcome (*undo)(SetupRun& run);
  // Null: nothing shows whether it was done.
  StepState (*state)(const nlohmann::json& status);
};

// In the order in which they are done; any of them can be done alone.
std::span<const SetupStep> SetupSteps();

// One row per step: name, title, about, takes, command, can_be_undone, state ("done", "open", "unknown"), text. For
// people, `omni setup --json` and the page. `status` of omnid; null: none.
nlohmann::json SetupStepRows(const nlohmann::json& status);

// Null: there is none of this name.
const SetupStep* FindSetupStep(const std::string& name);

// A shipped scene under the pen: omni setup is the application for as long as it takes.
struct Felt {
  double largest_force_N = 0;
  int presses = 0;  // of the button `select`
};

// Until `enough`, or in a rehearsal until the simulated hand has done what is to be done in this scene. Error: the
// scene cannot be used, or `patience_s` have passed, with what omnid says about it. Precondition: omnid runs.
base::Result<Felt> FeelScene(const SetupRun& run, const std::string& scene, double patience_s,
                             const std::function<bool(const Felt&)>& enough);

}  // namespace omni::tools
