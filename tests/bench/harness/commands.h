// Subcommands of omni-bench besides the benchmarks themselves.
#pragma once

#include "service/console/command.h"

namespace omni::bench {

using console::Command;

void AddPaper(Command& app);   // the published figures beside ours
void AddPaired(Command& app);  // one tick before and after a change
void AddPage(Command& app);    // rows into a page of Markdown

}  // namespace omni::bench
