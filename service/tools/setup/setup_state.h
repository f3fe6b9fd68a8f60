// How far a base is set up, as omnid's status and the user's files show it.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"

namespace omni::tools {

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

}  // namespace omni::tools
