// omnid's command line.
#pragma once

#include "service/console/command.h"
#include "service/daemon/run.h"

namespace omni::daemon {

inline constexpr const char* kOmnidAbout =
    "omnid: tracks the pen, renders forces, serves OpenXR applications through the Omni layer";

// Parsing `omnid` writes into `options`.
void AddOptions(console::Program& omnid, RunOptions& options);

}  // namespace omni::daemon
