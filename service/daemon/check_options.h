// Checks of omnid's options before anything starts.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/daemon/run.h"

namespace omni::daemon {

// "--OPTION: FILE: what is wrong, what to do" for a file that is missing, malformed or cannot be written, and for
// options of the twin without the twin. Empty: no problem. Makes no file and opens no device.
std::string OptionsProblem(const RunOptions& options);

// Removes the files that --replace lets recordings replace. Only after OptionsProblem had none.
base::Status MakeWay(const RunOptions& options);

// The same with names of recordings that are free: a base that comes back is recorded to FILE.2, FILE.3, ...
RunOptions WithFreeNames(RunOptions options);

// Only the check that --twin and --ideal come with --device twin.
std::string TwinChoiceProblem(const RunOptions& options);

}  // namespace omni::daemon
