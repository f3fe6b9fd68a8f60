// omni bench sculpt: omni_bench_sculpt (tests/bench/sculpt_cost.cc) does the work in a process of its own and prints
// the rows.
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "service/tools/bench.h"
#include "service/tools/child_process.h"

namespace omni::tools {

base::Result<BenchRows> BenchSculpt(const BenchOptions& options) {
  namespace fs = std::filesystem;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "omni_bench_sculpt";
  std::string output = (fs::temp_directory_path() / "omni-sculpt-XXXXXX").string();
  const int file = mkstemp(output.data());
  if (file < 0) return base::Error{"no temporary file can be made"};
  close(file);
  std::vector<std::string> arguments{program.string(), "--seed", std::to_string(options.seed)};
  if (options.quick) arguments.emplace_back("--quick");
  auto child = ChildProcess::Start(arguments, {}, output);
  const int status = child.ok() ? child->Wait() : 0;
  std::ifstream text(output);
  const nlohmann::ordered_json rows = nlohmann::ordered_json::parse(text, nullptr, false);
  std::error_code ignored;
  fs::remove(output, ignored);
  if (!child.ok()) return base::Error{child.error()};
  if (status != 0) return base::Error{program.string() + " ended with status " + std::to_string(status)};
  if (!rows.is_array()) return base::Error{program.string() + " printed no rows"};
  return BenchRows(rows.begin(), rows.end());
}

}  // namespace omni::tools
