// omni-bench layer: cost of the OpenXR layer, and error of the pen's poses.
#include <map>

#include "service/tools/common/row_table.h"
#include "service/tools/doctor/elf_file.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/program.h"
#include "tests/bench/openxr/layer_stage.h"

namespace omni::bench {
namespace {

using nlohmann::ordered_json;

constexpr int kRounds = 5;  // with the layer and without in turn, so that both see the same machine
constexpr int kSamples = 5000;
constexpr const char* kPen = "xrLocateSpace (pen)";
constexpr const char* kPast = "xrLocateSpace (pen, 10 ms ago)";
constexpr const char* kPass = "xrGetInstanceProperties (pass-through)";

// Medians of one call over the rounds.
struct CallTimes {
  std::vector<double> ns_median, ns_p99;
  double below = -1;
};
struct TimedCalls {
  std::vector<std::string> names;  // in the order of the program
  std::map<std::string, CallTimes> by_name;
};

base::Status TimeRound(const LayerStage& stage, bool layer, TimedCalls& calls) {
  const auto printed = stage.Run({"--runtime", stage.runtime_library()}, layer);
  if (!printed.ok()) return base::Error{printed.error()};
  for (const ordered_json& call : *printed) {
    const std::string name = call.at("call");
    if (calls.by_name.count(name) == 0) calls.names.push_back(name);
    CallTimes& times = calls.by_name[name];
    times.ns_median.push_back(call.at("ns_median"));
    times.ns_p99.push_back(call.at("ns_p99"));
    times.below = call.at("below");
  }
  return base::Ok{};
}

ordered_json HorizonOf(const std::string& call) {
  if (call == kPen) return 11;
  if (call == kPast) return -10;
  return nullptr;
}

void AddCalls(const TimedCalls& with, TimedCalls& without, BenchRows& rows) {
  for (const std::string& name : with.names) {
    for (const bool layer : {true, false}) {
      const CallTimes& times = layer ? with.by_name.at(name) : without.by_name[name];
      if (times.ns_median.empty()) continue;
      rows.push_back({{"call", name},
                      {"method", layer ? "layer" : "no layer"},
                      {"horizon_ms", HorizonOf(name)},
                      {"ns_median", tools::Quantile(times.ns_median, 0.5)},
                      {"error_mm_p95", nullptr}});
    }
  }
}

// What the layer adds, calls of the runtime and of the system, and the targets.
void AddCosts(const TimedCalls& with, TimedCalls& without, const std::vector<double>& syscalls, BenchRows& rows) {
  for (const std::string& name : with.names) {
    const CallTimes& layer = with.by_name.at(name);
    const CallTimes& bare = without.by_name[name];
    const double ns = tools::Quantile(layer.ns_median, 0.5);
    ordered_json row{
        {"table", "cost"},
        {"call", name},
        {"ns_layer", ns},
        {"ns_layer_p99", tools::Quantile(layer.ns_p99, 0.5)},
        {"ns_added", bare.ns_median.empty() ? ordered_json() : ordered_json(ns - tools::Quantile(bare.ns_median, 0.5))},
        {"calls_below", layer.below < 0 ? ordered_json() : ordered_json(layer.below)},
        {"syscalls", nullptr},
        {"wanted", nullptr}};
    for (std::size_t i = 0; i < std::size(kCountedCalls); ++i)
      if (name == kCountedCalls[i]) row["syscalls"] = syscalls[i];
    if (name == kPen) row["wanted"] = "ns_layer <= 1000, one call below, no system call";
    if (name == kPass) row["wanted"] = "ns_added <= 100";
    rows.push_back(row);
  }
}

base::Status AddMemory(const LayerStage& stage, BenchRows& rows) {
  const auto with = stage.Run({"--memory"}, true);
  const auto without = stage.Run({"--memory"}, false);
  if (!with.ok() || !without.ok()) return base::Error{with.ok() ? without.error() : with.error()};
  for (const auto& [what, key] : {std::pair("heap of an instance", "instance_bytes"),
                                  std::pair("heap of a session, its actions and spaces", "session_bytes"),
                                  std::pair("shared memory of omnid, mapped", "mapped_bytes")}) {
    rows.push_back({{"table", "memory"},
                    {"what", what},
                    {"bytes_layer", with->at(key)},
                    {"bytes_no_layer", without->at(key)},
                    {"bytes_added", with->at(key).get<long>() - without->at(key).get<long>()}});
  }
  const auto library = tools::ReadElfFile(stage.layer_library());
  if (!library.ok()) return base::Error{library.error()};
  rows.push_back({{"table", "library"},
                  {"bytes", library->bytes},
                  {"glibc", library->newest_glibc},
                  {"exported", library->exported.size()},
                  {"needed", library->needed.size()}});
  return base::Ok{};
}

base::Status AddLatency(const LayerStage& stage, int samples, BenchRows& rows) {
  const auto latency = stage.Run({"--latency", std::to_string(samples)}, true);
  if (!latency.ok()) return base::Error{latency.error()};
  rows.push_back({{"table", "latency"},
                  {"from", "a Hall sample of the twin"},
                  {"to", "xrLocateSpace tells its pose"},
                  {"ms_p50", latency->at("ms_p50")},
                  {"ms_p99", latency->at("ms_p99")},
                  {"n", latency->at("n")}});
  return base::Ok{};
}

}  // namespace

base::Result<BenchRows> BenchLayer(const BenchOptions& options) {
  auto predictions = RunBenchProgram("omni_bench_prediction", options);
  if (!predictions.ok()) return base::Error{predictions.error()};
  const auto stage = LayerStage::Open(options.seed);
  if (!stage.ok()) return base::Error{stage.error()};
  TimedCalls with;
  TimedCalls without;
  for (int round = 0; round < (options.quick ? 1 : kRounds); ++round) {
    for (const bool layer : {true, false}) {
      const base::Status timed = TimeRound(**stage, layer, layer ? with : without);
      if (!timed.ok()) return base::Error{timed.error()};
    }
  }
  const auto syscalls = (*stage)->CountSystemCallsOfCalls();
  if (!syscalls.ok()) return base::Error{syscalls.error()};
  BenchRows rows;
  AddCalls(with, without, rows);
  rows.insert(rows.end(), predictions->begin(), predictions->end());
  AddCosts(with, without, *syscalls, rows);
  const base::Status latency = AddLatency(**stage, options.quick ? kSamples / 10 : kSamples, rows);
  if (!latency.ok()) return base::Error{latency.error()};
  const base::Status memory = AddMemory(**stage, rows);
  if (!memory.ok()) return base::Error{memory.error()};
  return rows;
}

}  // namespace omni::bench
