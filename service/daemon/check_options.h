// Checks of omnid's options before anything starts.
#pragma once

#include <string>

#include "service/daemon/run.h"

namespace omni::daemon {

// "--OPTION: FILE: what is wrong, what to do" for a file that is missing, malformed or cannot be written, and for
// options of the twin without the twin. Empty: no problem. Makes no file and opens no device.
std::string OptionsProblem(const RunOptions& options);

// Only the check that --twin and --ideal come with --device twin.
std::string TwinChoiceProblem(const RunOptions& options);

}  // namespace omni::daemon
