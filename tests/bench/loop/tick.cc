// omni-bench tick: the whole tick - track, contact, force, allocate - in demanding scenes, with everything that changes
// in them, and lateness of ticks on a busy machine.
#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "service/base/limits.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/idle_timing.h"
#include "tests/bench/loop/tick_features.h"
#include "tests/support/rig/loop_replay.h"
#include "tests/support/usual_limit.h"

namespace omni::bench {
namespace {

constexpr int kTicksOfBatch = 1000;  // ticks
constexpr double kLate_s = 0.5e-3;
constexpr int kPriority = 80;

// Every triangle in four, of the same plane.
haptics::InputObject Subdivided(const haptics::InputObject& from) {
  haptics::InputObject fine = from;
  fine.triangles.clear();
  fine.triangle_material.clear();
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [found, fresh] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(fine.vertices_base_m.size()));
    if (fresh) {
      const base::Vec3 p = from.vertices_base_m[a], q = from.vertices_base_m[b];
      fine.vertices_base_m.push_back({0.5 * (p.x + q.x), 0.5 * (p.y + q.y), 0.5 * (p.z + q.z)});
    }
    return found->second;
  };
  for (std::size_t t = 0; t < from.triangles.size(); ++t) {
    const auto [a, b, c] = from.triangles[t];
    const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    fine.triangle_material.insert(fine.triangle_material.end(), 4, from.triangle_material[t]);
  }
  return fine;
}

// The triangles of a built scene, welded and in order, all of the first material.
haptics::SceneInput InputOf(const haptics::Scene& scene) {
  haptics::SceneInput input;
  input.name = scene.header().name;
  haptics::InputObject object;
  object.name = "body";
  for (const haptics::Vertex& v : scene.vertices()) object.vertices_base_m.push_back({v.x, v.y, v.z});
  for (const haptics::Triangle& t : scene.triangles()) {
    object.triangles.push_back({t.vertex[0], t.vertex[1], t.vertex[2]});
  }
  object.triangle_material.assign(object.triangles.size(), 0);
  input.materials.emplace_back();
  input.objects.push_back(std::move(object));
  return input;
}

base::Result<haptics::Scene> Build(const haptics::SceneInput& input) {
  haptics::BuildReport report;
  return haptics::BuildScene(input, report);
}

// How late ticks end when two threads also use the processors.
struct Lateness {
  bool fifo = false;
  std::uint64_t ticks = 0, late = 0;
};

Lateness MeasureLateness(test::ScanPlayer& player, bool wants_fifo, double seconds) {
  Lateness result;
  std::atomic<bool> stop{false};
  std::vector<std::jthread> hogs;
  for (int i = 0; i < 2; ++i) {
    hogs.emplace_back([&stop] {
      volatile std::uint64_t work = 0;
      while (!stop.load(std::memory_order_relaxed)) work = work + 1;
    });
  }
  std::jthread ticker([&] {
    if (wants_fifo) result.fifo = loop::RequestRealtime(kPriority).fifo;
    using Clock = std::chrono::steady_clock;
    const auto period = std::chrono::microseconds(1000);
    Clock::time_point due = Clock::now();
    for (result.ticks = 0; static_cast<double>(result.ticks) * base::kTickPeriod_s < seconds; ++result.ticks) {
      due += period;
      std::this_thread::sleep_until(due);
      if (player.at_end()) player.Start();
      player.Tick();
      const Clock::time_point end = Clock::now();
      result.late += std::chrono::duration<double>(end - due).count() > kLate_s ? 1 : 0;
      if (end > due + period) due = end;  // a missed tick is late once
    }
  });
  ticker.join();
  stop = true;
  return result;
}

// Input of the renderer in the longest stretch of touch.
std::vector<haptics::Input> LongestTouch(const loop::TickConfig& config, const haptics::Scene& scene,
                                         const std::vector<base::HallScan>& scans) {
  std::vector<haptics::Input> best, now;
  const auto player = std::make_unique<test::ScanPlayer>(config, scene, scans);
  for (const base::HallScan& scan : scans) {
    player->Tick();
    const loop::TickOutput& output = player->output();
    if (output.haptics.contact_count == 0) {
      now.clear();
      continue;
    }
    now.push_back({.t_ns = scan.t_ns,
                   .tracked = true,
                   .device_point_base_m = output.tool.device_point_base_m,
                   .velocity_base_m_s = output.tool.device_point_velocity_base_m_s,
                   .noise = output.tool.device_point_noise,
                   .noise_along = output.tool.device_point_noise_along,
                   .axis_base = output.tool.axis_base,
                   .delay_s = 1e-3,
                   .limit = test::UsualLimit()});
    if (now.size() > best.size()) best = now;
  }
  return best;
}

IdleTiming TimePlayer(const loop::TickConfig& config, const haptics::Scene& scene,
                      const std::vector<base::HallScan>& scans, int batches) {
  const auto player = std::make_unique<test::ScanPlayer>(config, scene, scans);
  return TimeWhenIdle(
      batches, kTicksOfBatch, 1, [&](std::uint64_t) { player->Tick(); },
      [&] {
        if (player->at_end()) player->Start();
      });
}

int SoftBodiesOf(const haptics::Scene& scene) {
  int bodies = 0;
  for (std::uint32_t object = 0; scene.live() != nullptr && object < scene.objects().size(); ++object) {
    bodies += scene.live()->soft_body(object) != nullptr;
  }
  return bodies;
}

class TickBench {
 public:
  TickBench(const BenchOptions& options, const loop::TickConfig& config) : options_(options), config_(config) {}

  base::Result<BenchRows> Run() {
    for (const char* name : {"extrusion", "dragon", "racetrack"}) {
      const std::string path = tools::ShippedScene(name);
      auto loaded = tools::LoadLiveScene(path, {});
      if (!loaded.ok()) return base::Error{loaded.error()};
      if (!loaded->live.lines.empty()) return base::Error{path + ": " + loaded->live.lines.front()};
      if (const auto status = Add(name, loaded->scene, path); !status.ok()) return base::Error{status.error()};
      if (std::string(name) == "dragon") {
        if (const auto status = AddRigid(loaded->scene, path); !status.ok()) return base::Error{status.error()};
      }
    }
    rows_.insert(rows_.end(), side_.begin(), side_.end());
    return rows_;
  }

 private:
  base::Status Add(const std::string& name, const haptics::Scene& scene, const std::string& path) {
    auto scans = test::RecordScans(config_, scene, path, options_.seed, config::DefaultTwin());
    if (!scans.ok()) return base::Error{scans.error()};
    const IdleTiming timing = TimePlayer(config_, scene, *scans, options_.quick ? 5 : 60);
    const test::ReplayTiming replay = test::ReplayTicks(config_, scene, *scans, scans->size());
    rows_.push_back(
        {{"scene", name},
         {"triangles", scene.header().triangle_count},
         {"soft_bodies", SoftBodiesOf(scene)},
         {"sculptable", scene.live() != nullptr ? scene.live()->sculpt_session_count() : 0},
         {"us_median", timing.us_median},
         {"us_p99", timing.us_p99},
         {"allocations", replay.allocations},
         {"contact_share", static_cast<double>(replay.contact_ticks) / static_cast<double>(replay.us.size())},
         {"quiet_batches", timing.quiet_batches}});
    return base::Ok{};
  }

  // The dragon's surface, four times as many triangles, hard.
  base::Status AddRigid(const haptics::Scene& dragon, const std::string& path) {
    haptics::SceneInput input = InputOf(dragon);
    input.objects[0] = Subdivided(input.objects[0]);
    input.materials[0].static_friction = input.materials[0].dynamic_friction = 0;
    auto scene = Build(input);
    if (!scene.ok()) return base::Error{scene.error()};
    if (const auto status = Add("rigid dragon, subdivided", *scene, path); !status.ok()) return status;
    auto scans = test::RecordScans(config_, *scene, path, options_.seed, config::DefaultTwin());
    if (!scans.ok()) return base::Error{scans.error()};
    AddLateness(*scene, *scans);
    return AddFeatures(input, *scene, *scans);
  }

  void AddLateness(const haptics::Scene& scene, const std::vector<base::HallScan>& scans) {
    const double seconds = options_.quick ? 2 : 60;
    for (const bool fifo : {false, true}) {
      const auto player = std::make_unique<test::ScanPlayer>(config_, scene, scans);
      const Lateness late = MeasureLateness(*player, fifo, seconds);
      side_.push_back({{"table", "two busy threads beside the tick"},
                       {"scheduling", fifo ? (late.fifo ? "SCHED_FIFO" : "SCHED_FIFO refused") : "SCHED_OTHER"},
                       {"ticks", late.ticks},
                       {"late_over_0.5_ms", late.late},
                       {"late_pct", 100.0 * static_cast<double>(late.late) / static_cast<double>(late.ticks)}});
    }
  }

  base::Status AddFeatures(const haptics::SceneInput& input, const haptics::Scene& scene,
                           const std::vector<base::HallScan>& scans) {
    const TouchedBody body{input, LongestTouch(config_, scene, scans)};
    if (body.touch.empty()) return base::Error{"omni-bench tick: the hand script never touches the dragon"};
    const auto rows = TickFeatureRows(body, options_.quick);
    if (!rows.ok()) return base::Error{rows.error()};
    side_.insert(side_.end(), rows->begin(), rows->end());
    return base::Ok{};
  }

  const BenchOptions& options_;
  loop::TickConfig config_;
  BenchRows rows_, side_;
};

}  // namespace

base::Result<BenchRows> BenchTick(const BenchOptions& options) {
  loop::FlushDenormals();
  const auto config = test::CalibratedTick(options.seed);
  if (!config.ok()) return base::Error{config.error()};
  return TickBench(options, *config).Run();
}

}  // namespace omni::bench
