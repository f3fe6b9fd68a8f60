// Subcommands of omni-bench besides the benchmarks themselves.
#pragma once

namespace CLI {
class App;
}

namespace omni::bench {

void AddPaper(CLI::App& app);   // the published figures beside ours
void AddPaired(CLI::App& app);  // one tick before and after a change
void AddPage(CLI::App& app);    // rows into a page of Markdown

}  // namespace omni::bench
