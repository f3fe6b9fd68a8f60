// omni: the one command-line tool.
#pragma once

#include <string>

namespace omni::tools {

// What every subcommand means by its exit status; --help says so too.
enum ExitStatus : int {
  kExitOk = 0,
  kExitFailed = 1,     // something did not work; stderr has one line that says what to do
  kExitUsage = 2,      // wrong arguments
  kExitNoService = 3,  // omnid does not run, or does not answer
};

// Writes "COMMAND: MESSAGE" to stderr; kExitFailed. command: "omni calibrate".
int Fail(const std::string& command, const std::string& message);

// Runs argv; the exit status for main.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace omni::tools
