// omni: the one command-line tool.
#pragma once

#include "service/console/command.h"
#include "service/console/exit_status.h"

namespace omni::tools {

using enum console::ExitStatus;
using console::Fail;
using console::Refuse;

// Runs argv; the exit status for main.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace omni::tools
