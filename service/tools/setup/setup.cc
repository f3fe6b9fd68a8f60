// omni setup: from plugging in to feeling a force, step by step.
#include "service/tools/setup/setup.h"

#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"

namespace omni::tools {
namespace {

constexpr const char* kSetupCommand = "omni setup";

struct SetupArguments {
  std::string step;
  bool rehearse = false, yes = false, undo = false, list = false, as_json = false;
};

int List(bool as_json) {
  const base::Result<nlohmann::json> status = FetchStatus("");
  const nlohmann::json rows = SetupStepRows(status.ok() ? *status : nlohmann::json());
  if (as_json) {
    PrintJson(rows);
    return kExitOk;
  }
  for (const nlohmann::json& row : rows) {
    std::string name = base::StringAt(row, "/name");
    name.resize(12, ' ');
    const std::string state = base::StringAt(row, "/state"), text = base::StringAt(row, "/text");
    Print(name + base::StringAt(row, "/title") + " (" + base::StringAt(row, "/takes") + ")" +
          (state == "unknown" ? "" : "\n            " + state + ": " + text) + "\n");
  }
  return kExitOk;
}

// True: go on. `undo`: the words that take it back; empty: nothing does.
bool Report(const StepOutcome& outcome, const std::string& undo, double seconds) {
  constexpr const char* kWords[] = {"done", "skipped", "FAILED"};
  Print(std::string(kWords[static_cast<int>(outcome.kind)]) + ": " + outcome.text +
        (outcome.kind == StepOutcome::Kind::kDone ? Format(" (%.0f s)", seconds) : std::string()) + "\n");
  if (outcome.kind == StepOutcome::Kind::kDone && !undo.empty()) Print("  to take it back: " + undo + "\n");
  return outcome.kind != StepOutcome::Kind::kFailed;
}

bool RunAndReport(StepOutcome (*action)(SetupRun& run), const std::string& undo, SetupRun& run) {
  const std::int64_t start_ns = base::MonotonicNow_ns();
  const StepOutcome outcome = action(run);
  return Report(outcome, undo, 1e-9 * static_cast<double>(base::MonotonicNow_ns() - start_ns));
}

// False: it failed, and the person goes no further.
bool Go(const SetupStep& step, int number, std::size_t of, SetupRun& run) {
  Print("\n" + std::to_string(number) + " of " + std::to_string(of) + "  " + step.title + " (" + step.takes + ")\n" +
        step.about + "\n");
  const bool stays = step.undo != nullptr && !run.rehearsal();
  const std::string undo = stays ? std::string("omni setup --undo ") + step.name : std::string();
  for (;;) {
    if (RunAndReport(step.run, undo, run)) return true;
    const std::string next = run.Choose("Quit, try again, or skip this step?", {"q", "t", "s"}, "q");
    if (next == "q") return false;
    if (next == "s") return true;
  }
}

int Setup(const SetupArguments& arguments) {
  if (arguments.list || arguments.as_json) return List(arguments.as_json);
  const SetupStep* const one = FindSetupStep(arguments.step);
  if (arguments.undo && one == nullptr)
    return FailUsage(kSetupCommand, "--undo: needs the name of a step; --list has them");
  if (one != nullptr && arguments.undo && one->undo == nullptr) {
    return FailUsage(kSetupCommand, std::string("--undo: ") + one->name + " changes nothing");
  }
  const auto run = SetupRun::Start(arguments.rehearse, arguments.yes);
  if (!run.ok()) return Fail(kSetupCommand, run.error());
  std::cout << std::unitbuf;  // what is said is read at once, through a pipe too
  if (arguments.rehearse)
    Print("REHEARSAL: everything is simulated by the digital twin, and nothing of yours is changed.\n");
  if (arguments.undo) {
    return RunAndReport(one->undo, "", **run) ? kExitOk : kExitFailed;
  }
  int number = 0;
  const std::int64_t start_ns = base::MonotonicNow_ns();
  for (const SetupStep& step : SetupSteps()) {
    ++number;
    if (one != nullptr && &step != one) continue;
    if (Go(step, number, SetupSteps().size(), **run)) continue;
    return Fail(kSetupCommand, std::string("\"") + step.title + "\" failed, see above; `omni setup " + step.name +
                                   "` tries it again, `omni setup` goes through all steps");
  }
  Print(Format("\nSet up in %.0f s.", 1e-9 * static_cast<double>(base::MonotonicNow_ns() - start_ns)) +
        " `omni monitor` shows the pen live, `omni doctor` what could be better.\n");
  return kExitOk;
}

std::vector<std::string> StepNames() {
  std::vector<std::string> names;
  for (const SetupStep& step : SetupSteps()) names.emplace_back(step.name);
  return names;
}

}  // namespace

void AddSetup(Command& app) {
  auto arguments = std::make_shared<SetupArguments>();
  Command setup = app.AddCommand("setup", "set up a base step by step, from plugging it in to feeling a force");
  setup.Add("step", arguments->step, "only this step (default: all of them)").OneOf(StepNames());
  setup.Add("--rehearse", arguments->rehearse, "with the digital twin (a simulation); changes nothing of yours");
  setup.Add("--yes", arguments->yes, "answer every question with yes, or with its first answer");
  setup.Add("--undo", arguments->undo, "take back what the step has changed");
  setup.Add("--list", arguments->list, "list the steps, and which are done");
  setup.Add("--json", arguments->as_json, "the same as JSON");
  setup.SetAction(arguments, Setup);
}

}  // namespace omni::tools
