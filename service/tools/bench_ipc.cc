// omni bench ipc: an OpenXR program (omni_bench_layer) times its own calls with and without the layer over the in-repo
// headless runtime, while omnid runs on the twin; system calls are counted under ptrace in a second run.
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/config/paths.h"
#include "service/tools/bench.h"
#include "service/tools/child_process.h"
#include "service/tools/scene_source.h"
#include "service/tools/statistics.h"
#include "service/tools/work_folder.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kLayer = "XR_APILAYER_OMNI_stylus";

// Names and order of what omni_bench_layer counts between its markers.
constexpr const char* kCountedCalls[] = {"xrLocateSpace (pen)", "xrLocateSpace (other hand)",
                                         "xrGetInstanceProperties (pass-through)"};
constexpr std::uint64_t kCountedTimes = 1000;

struct Folders {
  const WorkFolder owned;
  const fs::path build = fs::read_symlink("/proc/self/exe").parent_path().parent_path();
  const fs::path work = owned.path();  // empty: none could be made
};

Environment MakeEnvironment(const Folders& folders, bool layer) {
  Environment environment{"OMNI_SOCKET=" + (folders.work / "run" / "omnid.sock").string(),
                          "XR_RUNTIME_JSON=" + (folders.build / "share/openxr/1/omni_test_runtime.json").string(),
                          "XR_API_LAYER_PATH=" + (folders.build / "share/openxr/1/api_layers/explicit.d").string()};
  environment.push_back(std::string("XR_ENABLE_API_LAYERS=") + (layer ? kLayer : ""));
  return environment;
}

base::Result<ordered_json> TimeCalls(const Folders& folders, bool layer) {
  const fs::path output = folders.work / "calls.json";
  auto child = ChildProcess::Start({(folders.build / "bin/omni_bench_layer").string(), layer ? "--pen" : "--no-pen"},
                                   MakeEnvironment(folders, layer), output.string());
  if (!child.ok()) return base::Error{child.error()};
  const int status = child->Wait();
  if (status != 0) return base::Error{"omni_bench_layer ended with status " + std::to_string(status)};
  std::ifstream file(output);
  ordered_json calls = ordered_json::parse(file, nullptr, false);
  if (!calls.is_array()) return base::Error{"omni_bench_layer wrote no JSON"};
  return calls;
}

void AddRows(const ordered_json& calls, const std::string& suffix, BenchRows& rows) {
  for (const ordered_json& call : calls) {
    rows.push_back({{"call", call.at("call").get<std::string>() + suffix},
                    {"ns_median", call.at("ns_median")},
                    {"ns_p99", call.at("ns_p99")},
                    {"syscalls", nullptr}});
  }
}

base::Status CountCalls(const Folders& folders, BenchRows& rows) {
  auto counts = CountSystemCalls(
      {(folders.build / "bin/omni_bench_layer").string(), "--pen", "--count", std::to_string(kCountedTimes)},
      MakeEnvironment(folders, true));
  if (!counts.ok()) return base::Error{counts.error()};
  for (std::size_t i = 0; i < std::size(kCountedCalls) && i < counts->size(); ++i) {
    for (ordered_json& row : rows) {
      if (row["call"] != std::string(kCountedCalls[i]) + ", layer") continue;
      row["syscalls"] = static_cast<double>((*counts)[i]) / static_cast<double>(kCountedTimes);
    }
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
  return {{"call", name}, {"ns_median", Quantile(ns, 0.5)}, {"ns_p99", Quantile(ns, 0.99)}, {"syscalls", nullptr}};
}

base::Status AddReads(const Folders& folders, BenchRows& rows) {
  client::Connection connection({.role = protocol::ClientRole::kMonitor,
                                 .application = "omni bench",
                                 .engine = {},
                                 .socket_path = (folders.work / "run" / "omnid.sock").string()});
  protocol::ToolSample sample;
  for (int i = 0; i < 500 && !(connection.connected() && connection.state()->Newest(sample)); ++i) {
    connection.Poll(base::MonotonicNow_ns());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!connection.connected()) return base::Error{"no connection to omnid: " + connection.last_error()};
  const auto reader = connection.state();
  protocol::ToolSample after;
  protocol::InputSnapshot inputs;
  rows.push_back(TimeReads("StateReader::Newest", [&] { reader->Newest(sample); }));
  rows.push_back(
      TimeReads("StateReader::Around (10 ms ago)", [&] { reader->Around(sample.t_ns - 10'000'000, sample, after); }));
  rows.push_back(TimeReads("StateReader::Inputs", [&] { reader->Inputs(inputs); }));
  return base::Ok{};
}

}  // namespace

base::Result<BenchRows> BenchIpc(const BenchOptions& options) {
  const Folders folders;
  if (folders.work.empty()) return base::Error{"no temporary folder can be made"};
  std::error_code error;
  fs::create_directory(folders.work / "run", error);
  fs::permissions(folders.work / "run", fs::perms::owner_all, error);
  auto service = ChildProcess::Start(
      {(folders.build / "bin/omnid").string(), "--device", "twin", "--twin-seed", std::to_string(options.seed),
       "--twin-script", FindHandScript(FindScene("extrusion")), "--log-level", "error"},
      MakeEnvironment(folders, false));
  if (!service.ok()) return base::Error{service.error()};
  BenchRows rows;
  const base::Status reads = AddReads(folders, rows);
  if (!reads.ok()) return base::Error{reads.error()};
  for (const bool layer : {true, false}) {
    auto calls = TimeCalls(folders, layer);
    if (!calls.ok()) return base::Error{calls.error()};
    AddRows(*calls, layer ? ", layer" : ", no layer", rows);
  }
  const base::Status counted = CountCalls(folders, rows);
  if (!counted.ok()) return base::Error{counted.error()};
  return rows;
}

}  // namespace omni::tools
