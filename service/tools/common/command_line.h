// omni: the one command-line tool.
#pragma once

#include "service/console/command.h"
#include "service/console/exit_status.h"

namespace omni::tools {

using enum console::ExitStatus;
using console::Fail;
using console::Refuse;

inline constexpr const char* kOmniAbout = "omni: inspect and set up the Omni haptic base, its service and its scenes";

// Every command but hidden ones.
void AddCommands(console::Program& omni);

// Runs argv; the exit status for main.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace omni::tools
