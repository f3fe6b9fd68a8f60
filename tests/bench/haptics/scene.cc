// omni-bench scene: cost of loading, each file in a fresh process (`omni scene cost`), counted by the system.
#include <filesystem>

#include "service/config/paths.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/haptics/scene_files.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/program.h"
#include "tests/bench/harness/work_folder.h"
#include "tests/support/process/child_process.h"

namespace omni::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

base::Result<ordered_json> CostOf(const fs::path& work, const std::string& file) {
  const fs::path output = work / "cost.json";
  const base::Result<std::string> omni = ProgramBeside("omni");
  if (!omni.ok()) return base::Error{omni.error()};
  auto child = test::ChildProcess::Start({*omni, "scene", "cost", file},
                                         {"XDG_CACHE_HOME=" + (work / "cache").string()}, output.string());
  if (!child.ok()) return base::Error{child.error()};
  const int status = child->Wait();
  if (status != 0) return base::Error{"omni scene cost " + file + " ended with status " + std::to_string(status)};
  const base::Result<std::string> text = tools::ReadJsonFile(output.string(), tools::kRowsJson);
  ordered_json cost = text.ok() ? ordered_json::parse(*text) : ordered_json();
  if (!cost.is_object()) return base::Error{"omni scene cost wrote no JSON"};
  return cost;
}

base::Status AddRow(const fs::path& work, const BenchFile& file, BenchRows& rows) {
  auto cost = CostOf(work, file.path);
  if (!cost.ok()) return base::Error{cost.error()};
  ordered_json row{{"scene", file.name}, {"tagged", file.tagged}};
  for (const char* key : {"bytes_file", "bytes_read", "images_decoded", "threads", "rss_MB", "bytes_counted", "load_ms",
                          "build_ms", "cached", "triangles"}) {
    row[key] = (*cost)[key];
  }
  row["read_pct"] = 100 * row["bytes_read"].get<double>() / row["bytes_file"].get<double>();
  rows.push_back(std::move(row));
  return base::Ok{};
}

}  // namespace

base::Result<BenchRows> BenchScene(const BenchOptions& options) {
  const WorkFolder work;
  if (work.path().empty()) return base::Error{"no temporary folder; set TMPDIR to a place with 500 MB"};
  std::vector<BenchFile> files = WriteBenchFiles(work.path().string(), options.seed, options.quick ? 20 : 1);
  for (const char* shipped : {"extrusion", "dragon", "racetrack"})
    files.push_back({shipped, tools::ShippedScene(shipped), true});
  BenchRows rows;
  // The second time from the cache, if it was cached.
  for (const int time : {1, 2}) {
    for (const BenchFile& file : files) {
      BenchFile named = file;
      if (time == 2) named.name += " again";
      const base::Status added = AddRow(work.path(), named, rows);
      if (!added.ok()) return base::Error{added.error()};
    }
  }
  return rows;
}

}  // namespace omni::bench
