// omni setup: one row per step, from plugging in to feeling a force.
#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/tools/setup/setup_run.h"
#include "service/tools/setup/setup_state.h"

namespace omni::tools {

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

}  // namespace omni::tools
