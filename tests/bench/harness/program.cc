#include "tests/bench/harness/program.h"

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>

#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/printed_rows.h"
#include "tests/support/process/child_process.h"

namespace omni::bench {

namespace fs = std::filesystem;

base::Result<std::string> ProgramBeside(const std::string& name) {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / name;
  std::error_code ignored;
  if (fs::exists(program, ignored)) return program.string();
  return base::Error{program.string() + " is not built; cmake --build build/bench --target omni_benches"};
}

base::Result<BenchRows> RunBenchProgram(const std::string& name, const BenchOptions& options) {
  const base::Result<std::string> program = ProgramBeside(name);
  if (!program.ok()) return base::Error{program.error()};
  std::string output = (fs::temp_directory_path() / "omni-bench-XXXXXX").string();
  const int file = mkstemp(output.data());
  if (file < 0) return base::Error{"no temporary file can be made"};
  close(file);
  std::vector<std::string> words{*program, "--seed", std::to_string(options.seed)};
  if (options.quick) words.emplace_back("--quick");
  if (options.ticks > 0) words.insert(words.end(), {"--ticks", std::to_string(options.ticks)});
  if (!options.mesh.empty()) words.insert(words.end(), {"--mesh", options.mesh});
  auto child = test::ChildProcess::Start(words, {}, output);
  const int status = child.ok() ? child->Wait() : 0;
  const base::Result<std::string> text = tools::ReadJsonFile(output, tools::kRowsJson);
  std::error_code ignored;
  fs::remove(output, ignored);
  if (!child.ok()) return base::Error{child.error()};
  if (status != 0) return base::Error{name + " ended with status " + std::to_string(status)};
  auto rows = text.ok() ? nlohmann::ordered_json::parse(*text) : nlohmann::ordered_json();
  if (!rows.is_array()) return base::Error{name + " printed no rows"};
  ReadNotMeasured(rows);
  return BenchRows(rows.begin(), rows.end());
}

}  // namespace omni::bench
