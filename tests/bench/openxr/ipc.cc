// omni-bench ipc: an OpenXR program (omni_bench_layer) times its own calls with and without the layer over the in-repo
// headless runtime, while omnid runs on the twin; system calls are counted under ptrace in a second run.
#include <chrono>
#include <thread>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/openxr/layer_stage.h"

namespace omni::bench {
namespace {

using nlohmann::ordered_json;

void AddRows(const ordered_json& calls, const std::string& suffix, BenchRows& rows) {
  for (const ordered_json& call : calls) {
    rows.push_back({{"call", call.at("call").get<std::string>() + suffix},
                    {"ns_median", call.at("ns_median")},
                    {"ns_p99", call.at("ns_p99")},
                    {"syscalls", nullptr}});
  }
}

base::Status CountCalls(const LayerStage& stage, BenchRows& rows) {
  const auto counts = stage.CountSystemCallsOfCalls();
  if (!counts.ok()) return base::Error{counts.error()};
  for (std::size_t i = 0; i < std::size(kCountedCalls); ++i) {
    for (ordered_json& row : rows)
      if (row["call"] == std::string(kCountedCalls[i]) + ", layer") row["syscalls"] = (*counts)[i];
  }
  return base::Ok{};
}

// Reads of the state memory alone, without OpenXR.
template <class Call>
ordered_json TimeReads(const char* name, Call call) {
  constexpr int kCallBatches = 4000;
  constexpr int kPerBatch = 64;
  std::vector<double> ns;
  for (int batch = 0; batch < kCallBatches; ++batch) {
    const std::int64_t begin_ns = base::MonotonicNow_ns();
    for (int i = 0; i < kPerBatch; ++i) call();
    ns.push_back(static_cast<double>(base::MonotonicNow_ns() - begin_ns) / kPerBatch);
  }
  return {{"call", name},
          {"ns_median", tools::Quantile(ns, 0.5)},
          {"ns_p99", tools::Quantile(ns, 0.99)},
          {"syscalls", nullptr}};
}

base::Status AddReads(const LayerStage& stage, BenchRows& rows) {
  client::Connection connection({.role = protocol::ClientRole::kMonitor,
                                 .application = "omni-bench",
                                 .engine = {},
                                 .socket_path = stage.socket_path()});
  protocol::ToolSample sample;
  for (int i = 0; i < 500 && !(connection.connected() && connection.state()->ReadNewest(sample)); ++i) {
    connection.Poll(base::MonotonicNow_ns());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!connection.connected()) return base::Error{"no connection to omnid: " + connection.last_error()};
  const auto reader = connection.state();
  protocol::ToolSample after;
  protocol::InputSnapshot inputs;
  rows.push_back(TimeReads("StateReader::ReadNewest", [&] { reader->ReadNewest(sample); }));
  rows.push_back(TimeReads("StateReader::ReadAround (10 ms ago)",
                           [&] { reader->ReadAround(sample.t_ns - 10'000'000, sample, after); }));
  rows.push_back(TimeReads("StateReader::ReadInputs", [&] { reader->ReadInputs(inputs); }));
  return base::Ok{};
}

}  // namespace

base::Result<BenchRows> BenchIpc(const BenchOptions& options) {
  const auto stage = LayerStage::Open(options.seed);
  if (!stage.ok()) return base::Error{stage.error()};
  BenchRows rows;
  const base::Status reads = AddReads(**stage, rows);
  if (!reads.ok()) return base::Error{reads.error()};
  for (const bool layer : {true, false}) {
    auto calls = (*stage)->Run({}, layer);
    if (!calls.ok()) return base::Error{calls.error()};
    AddRows(*calls, layer ? ", layer" : ", no layer", rows);
  }
  const base::Status counted = CountCalls(**stage, rows);
  if (!counted.ok()) return base::Error{counted.error()};
  return rows;
}

}  // namespace omni::bench
