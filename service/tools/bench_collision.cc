// omni bench collision: runs omni_bench_collision, which is built with the peers and stands alone because of them.
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "service/tools/bench.h"
#include "service/tools/child_process.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;

// The one row that says what the issue of this bench is about: ratios within the run.
nlohmann::ordered_json Ratio(const char* what, double a, double b) {
  return {{"table", "ratios"}, {"what", what}, {"ratio", b > 0 ? nlohmann::ordered_json(a / b) : nullptr}};
}

double Value(const BenchRows& rows, const std::string& engine, std::uint64_t triangles, const char* key) {
  for (const auto& row : rows) {
    if (row.contains("table") || row.value("mesh", "") != "lump" || row.value("engine", "") != engine) continue;
    if (row.value("triangles", std::uint64_t{0}) == triangles && row.at(key).is_number()) return row.at(key);
  }
  return 0;
}

void AddRatios(BenchRows& rows) {
  std::uint64_t least = 0, most = 0;
  for (const auto& row : rows) {
    if (row.contains("table") || row.value("mesh", "") != "lump") continue;
    const std::uint64_t n = row.value("triangles", std::uint64_t{0});
    least = least == 0 ? n : std::min(least, n);
    most = std::max(most, n);
  }
  if (most == 0) return;
  const auto us = [&](const char* engine, std::uint64_t n) { return Value(rows, engine, n, "us_median"); };
  const auto ms = [&](const char* engine) { return Value(rows, engine, most, "build_ms"); };
  rows.push_back(Ratio("omni-proxy, largest lump over smallest", us("omni-proxy", most), us("omni-proxy", least)));
  rows.push_back(Ratio("the contact alone, largest lump over smallest", us("study-omni-contact", most),
                       us("study-omni-contact", least)));
  rows.push_back(
      Ratio("embree-warm over omni-closest, largest lump", us("embree-warm", most), us("omni-closest", most)));
  rows.push_back(Ratio("omni's tree over embree's, build, largest lump", ms("omni-closest"), ms("embree")));
}

}  // namespace

base::Result<BenchRows> BenchCollision(const BenchOptions& options) {
  std::string folder = (fs::temp_directory_path() / "omni-bench-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return base::Error{"no temporary folder can be made"};
  const fs::path output = fs::path(folder) / "rows.json";
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "omni_bench_collision";
  std::vector<std::string> words{program.string(), "--seed", std::to_string(options.seed)};
  if (options.quick) words.emplace_back("--quick");
  if (options.ticks > 0) words.insert(words.end(), {"--ticks", std::to_string(options.ticks)});
  if (!options.mesh.empty()) words.insert(words.end(), {"--mesh", options.mesh});
  auto child = ChildProcess::Start(words, {}, output.string());
  if (!child.ok()) return base::Error{child.error()};
  const int status = child->Wait();
  std::ifstream file(output);
  const auto rows = nlohmann::ordered_json::parse(file, nullptr, false);
  std::error_code error;
  fs::remove_all(folder, error);
  if (status != 0 || !rows.is_array()) {
    return base::Error{"omni_bench_collision ended with status " + std::to_string(status) +
                       "; is it built (target omni_bench_collision)?"};
  }
  BenchRows all(rows.begin(), rows.end());
  AddRatios(all);
  return all;
}

}  // namespace omni::tools
