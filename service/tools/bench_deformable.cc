// omni bench deformable: omni_bench_deformable judges soft bodies; it is a program of its own, because its reference
// solvers belong to the tests.
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "service/tools/bench.h"
#include "service/tools/child_process.h"

namespace omni::tools {

base::Result<BenchRows> BenchDeformable(const BenchOptions& options) {
  namespace fs = std::filesystem;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "omni_bench_deformable";
  if (!fs::exists(program))
    return base::Error{program.string() + " is missing; build the target omni_bench_deformable"};
  const fs::path output = fs::temp_directory_path() / ("omni-bench-deformable-" + std::to_string(getpid()) + ".json");
  std::vector<std::string> command{program.string(), "--seed", std::to_string(options.seed)};
  if (options.quick) command.emplace_back("--quick");
  auto child = ChildProcess::Start(command, {}, output.string());
  if (!child.ok()) return base::Error{child.error()};
  const int status = child->Wait();
  std::ifstream file(output);
  const auto rows = nlohmann::ordered_json::parse(file, nullptr, false);
  std::error_code error;
  fs::remove(output, error);
  if (status != 0) return base::Error{"omni_bench_deformable ended with status " + std::to_string(status)};
  if (!rows.is_array()) return base::Error{"omni_bench_deformable wrote no JSON"};
  return rows.get<BenchRows>();
}

}  // namespace omni::tools
