// omni bench: tables for people, flat JSON rows for machines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/result.h"

namespace omni::tools {

// Rows are flat objects; keys in a stated order; not measured = null.
using BenchRows = std::vector<nlohmann::ordered_json>;

struct BenchOptions {
  std::uint64_t ticks = 1'000'000;  // loop: per scene
  std::uint64_t seed = 1;
};

// Tick alone, per shipped scene: scene, ticks, us_median, us_p99, us_max, allocations, late_ticks.
base::Result<BenchRows> BenchLoop(const BenchOptions& options);

// Calls through the layer over the in-repo runtime: call, ns_median, ns_p99, syscalls.
base::Result<BenchRows> BenchIpc(const BenchOptions& options);

// Force map against the twin, by model and gap; timing: model, gap_mm, error_median_pct, ..., stage, us_median, us_p99.
base::Result<BenchRows> BenchForce(const BenchOptions& options);

// Heat runs of the paper on the twin and in the host: run, model, peak_C, peak_s, end_C, copper_peak_C, ...
base::Result<BenchRows> BenchThermal(const BenchOptions& options);

// {"name", "commit", "machine", "rows"}
nlohmann::ordered_json BenchDocument(const std::string& name, const BenchRows& rows);
// Aligned columns, one line a row.
std::string BenchTable(const BenchRows& rows);

}  // namespace omni::tools
