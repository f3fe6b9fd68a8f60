// Error of the layer's predicted poses, compared with a held pose: the twin's hands play in virtual time, every sample
// is published as omnid does, and after each the layer is queried for 10, 20 and 40 ms later. The reference is the
// twin's own record of the tip. Prints a JSON array of rows: call, method, horizon_ms, ns_median, error_mm_p95; side
// table: the same by motion, with the error's median and 99th percentile.
//   --seed N   of the twin and of the free motions; --quick: one free motion only
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <random>
#include <vector>

#include <nlohmann/json.hpp>

#include "layer/src/spaces/tool_motion.h"
#include "service/client/state_reader.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/clients/publish.h"
#include "service/daemon/virtual_run.h"
#include "service/haptics/scene/scene.h"
#include "service/sim/twin/twin.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/arguments.h"
#include "tests/bench/harness/work_folder.h"
#include "tests/bench/printed_rows.h"
#include "tests/support/rig/loop_replay.h"

namespace omni::bench {
namespace {

using nlohmann::ordered_json;

constexpr std::array<int, 3> kHorizons_ms = {10, 20, 40};
constexpr const char* kPredicted = "layer";
constexpr const char* kHeld = "hold last";
constexpr std::int64_t kMillisecond_ns = 1'000'000;

// A prediction of a future time.
struct Said {
  std::int64_t t_ns = 0;  // time of the requested pose
  glm::dvec3 predicted_m;
  glm::dvec3 held_m;
};

struct Motion {
  std::string name;
  haptics::Scene scene;
  sim::HandScript hand;
};

// Strokes between seeded points above the base, each in a quarter to half a second: a hand that writes in the air.
Motion FreeMotion(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Motion motion{"free strokes, seed " + std::to_string(seed), {}, {}};
  motion.hand.name = "free";
  motion.hand.tremor_m = 5e-5;
  for (int i = 0; i < 40; ++i) {
    sim::HandWaypoint point;
    point.duration_s = i == 0 ? 0 : between(0.25, 0.5);
    point.tip_base_m = {between(-0.03, 0.03), between(-0.03, 0.03), between(0.055, 0.085)};
    motion.hand.waypoints.push_back(point);
  }
  return motion;
}

base::Result<Motion> SceneMotion(const std::string& name) {
  const std::string path = tools::ShippedScene(name);
  auto loaded = tools::LoadScene(path, {});
  if (!loaded.ok()) return base::Error{loaded.error()};
  auto hand = sim::LoadHandScript(tools::FindHandScript(path));
  if (!hand.ok()) return base::Error{hand.error()};
  return Motion{name, std::move(loaded->scene), *hand};
}

// The true tip, between two records of the twin by a straight line. False: no pen there.
class TrueTip {
 public:
  explicit TrueTip(const tools::CsvTable& table) : table_(table) {}

  bool At(std::int64_t t_ns, glm::dvec3& tip_m) const {
    const std::vector<double>& times = table_["t_ns"];
    const auto after = std::lower_bound(times.begin(), times.end(), static_cast<double>(t_ns));
    if (after == times.begin() || after == times.end()) return false;
    const auto i = static_cast<std::size_t>(after - times.begin());
    if (table_["present"][i - 1] < 0.5 || table_["present"][i] < 0.5) return false;
    const double s = (static_cast<double>(t_ns) - times[i - 1]) / (times[i] - times[i - 1]);
    static const char* const kColumns[3] = {"tip_x_m", "tip_y_m", "tip_z_m"};
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& column = table_[kColumns[axis]];
      tip_m[axis] = column[i - 1] + s * (column[i] - column[i - 1]);
    }
    return true;
  }

 private:
  const tools::CsvTable& table_;
};

// One state memory, written as omnid writes it and read as the layer reads it.
struct Memory {
  std::unique_ptr<ipc::StatePublisher> publisher = std::move(ipc::StatePublisher::Create(1).value());
  std::shared_ptr<const client::StateReader> reader =
      client::StateReader::Map(base::UniqueFd(::dup(publisher->fd())), sizeof(protocol::StateMemory)).value();
};

using SaidByHorizon = std::array<std::vector<Said>, kHorizons_ms.size()>;

base::Result<SaidByHorizon> Play(const Motion& motion, std::uint64_t seed, const std::string& record) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto config = test::CalibratedTick(seed);
  if (!config.ok()) return base::Error{config.error()};
  auto twin = sim::MakeVirtualTwin(
      device, {.seed = seed, .script = motion.hand, .truth = config::DefaultTwin(), .recording_path = record},
      motion.hand.duration_s());
  Memory memory;
  if (!memory.reader) return base::Error{"the state memory cannot be mapped"};
  daemon::PublishSink sink(*memory.publisher);
  SaidByHorizon said;
  daemon::RunVirtual(*config, *twin, motion.scene, {}, [&](const base::HallScan& scan, const loop::TickOutput& output) {
    sink.Publish(output, scan, {});
    if (output.tool.status != base::TrackingStatus::kTracking) return;
    const layer::ToolMotion now = layer::ToolMotionAt(*memory.reader, scan.t_ns, scan.t_ns);
    for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
      const std::int64_t t_ns = scan.t_ns + kHorizons_ms[h] * kMillisecond_ns;
      const layer::ToolMotion then = layer::ToolMotionAt(*memory.reader, t_ns, scan.t_ns);
      if (now.valid && then.valid) said[h].push_back({t_ns, then.X_BT.X.p, now.X_BT.X.p});
    }
  });
  return said;
}

// Time of one call; the pen moves, the newest sample is `horizon_ms` old.
double CallTime_ns(int horizon_ms) {
  using Clock = std::chrono::steady_clock;
  Memory memory;
  protocol::ToolSample sample;
  sample.flags = protocol::kToolPoseValid | protocol::kToolTracked;
  sample.linear_velocity_base_m_s = {0.1, 0, 0};
  sample.t_ns = kMillisecond_ns;
  memory.publisher->Publish(sample, {});
  std::vector<double> ns;
  double sum = 0;
  for (int batch = 0; batch < 2000; ++batch) {
    constexpr int kPerBatch = 64;
    const Clock::time_point begin = Clock::now();
    for (int i = 0; i < kPerBatch; ++i) {
      const std::int64_t t_ns = sample.t_ns + horizon_ms * kMillisecond_ns + i;
      sum += layer::ToolMotionAt(*memory.reader, t_ns, sample.t_ns).X_BT.X.p.x;
    }
    ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / kPerBatch);
  }
  return std::isfinite(sum) ? tools::Quantile(ns, 0.5) : 0;
}

// Millimetres off, by method and horizon.
using Errors = std::map<std::pair<std::string, int>, std::vector<double>>;

void Judge(const SaidByHorizon& said, const TrueTip& truth, Errors& errors) {
  for (std::size_t h = 0; h < kHorizons_ms.size(); ++h) {
    for (const Said& one : said[h]) {
      glm::dvec3 tip_m;
      if (!truth.At(one.t_ns, tip_m)) continue;
      errors[{kPredicted, kHorizons_ms[h]}].push_back(1e3 * glm::length(one.predicted_m - tip_m));
      errors[{kHeld, kHorizons_ms[h]}].push_back(1e3 * glm::length(one.held_m - tip_m));
    }
  }
}

void AddByMotion(const std::string& name, const Errors& errors, std::vector<ordered_json>& rows) {
  for (const auto& [key, mm] : errors) {
    rows.push_back({{"table", "motions"},
                    {"motion", name},
                    {"method", key.first},
                    {"horizon_ms", key.second},
                    {"error_mm_median", tools::Quantile(mm, 0.5)},
                    {"error_mm_p95", tools::Quantile(mm, 0.95)},
                    {"error_mm_p99", tools::Quantile(mm, 0.99)},
                    {"n", mm.size()}});
  }
}

int Run(std::uint64_t seed, bool quick) {
  std::vector<Motion> motions;
  for (const char* name : {"extrusion", "racetrack"}) {
    if (quick) break;
    auto motion = SceneMotion(name);
    if (!motion.ok()) {
      std::cerr << "omni_bench_prediction: " << motion.error() << "\n";
      return 1;
    }
    motions.push_back(std::move(*motion));
  }
  for (std::uint64_t i = 1; i <= (quick ? 1u : 3u); ++i) motions.push_back(FreeMotion(1000 * seed + i));

  const bench::WorkFolder folder;
  Errors all;
  std::vector<ordered_json> side;
  for (const Motion& motion : motions) {
    const std::string record = (folder.path() / (std::to_string(&motion - motions.data()) + ".csv")).string();
    const auto said = Play(motion, seed, record);
    const auto table = tools::CsvTable::Read(record);
    if (!said.ok() || !table.ok()) {
      std::cerr << "omni_bench_prediction: " << (said.ok() ? table.error() : said.error()) << "\n";
      return 1;
    }
    Errors errors;
    Judge(*said, TrueTip(*table), errors);
    AddByMotion(motion.name, errors, side);
    for (const auto& [key, mm] : errors) all[key].insert(all[key].end(), mm.begin(), mm.end());
  }
  ordered_json rows = ordered_json::array();
  for (const int horizon_ms : kHorizons_ms) {
    const double predict_ns = CallTime_ns(horizon_ms);
    const double hold_ns = CallTime_ns(0);
    for (const auto& [method, ns] : {std::pair(kPredicted, predict_ns), std::pair(kHeld, hold_ns)}) {
      rows.push_back({{"call", "pose of the pen"},
                      {"method", method},
                      {"horizon_ms", horizon_ms},
                      {"ns_median", ns},
                      {"error_mm_p95", tools::Quantile(all[{method, horizon_ms}], 0.95)}});
    }
  }
  for (ordered_json& row : side) rows.push_back(std::move(row));
  PrintRows(rows);
  return 0;
}

}  // namespace
}  // namespace omni::bench

int main(int argc, char** argv) {
  std::string seed = "1";
  bool quick = false;
  const auto ended = omni::bench::ParseArguments(argc, argv, "omni_bench_prediction",
                                                 {{"--quick", &quick}, {"--seed", nullptr, &seed}});
  return ended ? *ended : omni::bench::Run(omni::bench::Number(seed), quick);
}
