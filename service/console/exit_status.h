// What every program of ours means by its exit status; docs/howto/install.md has the table.
#pragma once

namespace omni::console {

enum ExitStatus : int {
  kExitOk = 0,
  kExitFailed = 1,     // something did not work; stderr has one line that says what to do
  kExitUsage = 2,      // wrong arguments
  kExitNoService = 3,  // omnid does not run, or does not answer
};

// For --help.
inline constexpr const char* kExitStatusHelp =
    "Exit status: 0 it worked; 1 something did not, stderr says what to do; 2 wrong arguments; 3 omnid does not run.";

}  // namespace omni::console
