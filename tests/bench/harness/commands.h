// Subcommands of omni-bench besides the benchmarks themselves.
#pragma once

#include <string>

#include "service/console/command.h"
#include "service/tools/common/row_table.h"

namespace omni::bench {

using console::Command;

// Writes the rows of `omni-bench NAME` to a file, if there is one. Exit status: kExitFailed, with an error message,
// when that fails or when figures that should have been measured are missing.
int KeepRows(const std::string& name, const tools::Rows& rows, const std::string& json_path);

void AddPaper(Command& app);   // the published figures and ours
void AddPaired(Command& app);  // one tick before and after a change

}  // namespace omni::bench
