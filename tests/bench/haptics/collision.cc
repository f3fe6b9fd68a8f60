// omni-bench collision: runs omni_bench_collision, a separate program because it is built with the peers.
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/program.h"

namespace omni::bench {
namespace {

// The main results: ratios within the run.
nlohmann::ordered_json Ratio(const char* what, double a, double b) {
  return {{"table", "ratios"}, {"what", what}, {"ratio", a / b}};
}

double Value(const BenchRows& rows, const std::string& engine, std::uint64_t triangles, const char* key) {
  for (const auto& row : rows) {
    if (row.contains("table") || row.value("mesh", "") != "lump" || row.value("engine", "") != engine) continue;
    if (row.value("triangles", std::uint64_t{0}) == triangles && row.at(key).is_number()) return row.at(key);
  }
  return tools::kNotMeasured;
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
  auto rows = RunBenchProgram("omni_bench_collision", options);
  if (!rows.ok()) return rows;
  AddRatios(*rows);
  return rows;
}

}  // namespace omni::bench
