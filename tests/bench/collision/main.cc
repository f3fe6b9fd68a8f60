// omni_bench_collision: run by `omni-bench collision`; prints rows as JSON.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <optional>

#include <nlohmann/json.hpp>

#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"
#include "tests/bench/collision/judge.h"
#include "tests/bench/collision/path.h"
#include "tests/bench/collision/timing.h"
#include "tests/bench/printed_rows.h"

namespace omni::collision {
namespace {

using nlohmann::ordered_json;
using tools::Quantile;

struct Options {
  std::uint64_t seed = 1;
  std::uint64_t ticks = 1'000'000;  // judged, over all bodies and paths
  std::uint64_t checks = 10'000;    // of them compared with sums over all triangles, per body
  int batches = 12;                 // undisturbed ones wanted, per engine and style
  int builds = 3;
  std::uint32_t largest = 1'000'000;
  std::uint32_t only = 0;  // one lump of so many triangles ...
  bool gear = false;       // ... or one gear
  std::string mesh;
};

struct Timed {
  std::unique_ptr<Engine> engine;
  std::vector<double> build_ms;
  BuildCost cost;
  std::vector<Times> styles = std::vector<Times>(std::size(kStyles));
  double spent_s = 0, error_m = 0;
  std::uint64_t ticks = 0;
};

// All batches of the paths, engines taking turns batch by batch. An engine that has used up its patience is skipped.
void TimeEngines(const Oracle& oracle, const std::vector<std::vector<Vec3>>& paths, const Options& options,
                 std::vector<Timed>& engines) {
  constexpr double kPatience_s = 12;
  for (std::size_t s = 0; s < paths.size(); ++s) {
    for (Timed& timed : engines) timed.engine->Start(paths[s].front());
    for (std::size_t begin = 0; begin + kBatch <= paths[s].size(); begin += kBatch) {
      const std::span<const Vec3> tips(paths[s].data() + begin, kBatch);
      for (Timed& timed : engines) {
        const std::size_t done = timed.styles[s].median_us.size();
        const double share = kPatience_s * static_cast<double>(s + 1) / static_cast<double>(paths.size());
        if (done >= static_cast<std::size_t>(options.batches) || (done > 0 && timed.spent_s > share)) continue;
        std::vector<double> distances(kBatch);
        const auto start = std::chrono::steady_clock::now();
        RunBatch(*timed.engine, tips, distances, timed.styles[s]);
        timed.spent_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        timed.ticks += kBatch;
        for (std::size_t i = 0; i < kBatch; i += 50) {
          if (distances[i] < 0) continue;
          const double truth = std::sqrt(oracle.NearestTo(tips[i]).distance_squared);
          timed.error_m = std::max(timed.error_m, std::abs(distances[i] - truth));
        }
      }
    }
  }
}

std::vector<double> All(const Timed& timed, std::vector<double> Times::*member) {
  std::vector<double> all;
  for (const Times& times : timed.styles) all.insert(all.end(), (times.*member).begin(), (times.*member).end());
  return all;
}

ordered_json Row(const Body& body, const Timed& timed, const Verdict* verdict) {
  const auto n = static_cast<double>(body.triangles.size());
  ordered_json row{{"engine", timed.engine->name()},
                   {"mesh", body.name},
                   {"triangles", body.triangles.size()},
                   {"us_median", Quantile(All(timed, &Times::median_us), 0.5)},
                   {"us_p99", Quantile(All(timed, &Times::p99_us), 0.5)},
                   {"us_p999", Quantile(All(timed, &Times::p999_us), 0.5)},
                   {"build_ms", Quantile(timed.build_ms, 0.5)},
                   {"bytes_per_triangle", timed.cost.tree_bytes / n},
                   {"missed", nullptr},
                   {"false_contacts", nullptr},
                   {"direction_p99_deg", nullptr},
                   {"n", timed.ticks},
                   {"quiet_batches", All(timed, &Times::median_us).size()},
                   {"distance_error_um", timed.error_m > 0 ? ordered_json(1e6 * timed.error_m) : ordered_json()}};
  if (verdict != nullptr) {
    row["missed"] = verdict->missed;
    row["false_contacts"] = verdict->wrong;
    if (body.smooth) row["direction_p99_deg"] = Quantile(verdict->direction_deg, 0.99);
    row["n"] = verdict->ticks;
  }
  return row;
}

ordered_json StyleRow(const Body& body, const Timed& timed, std::size_t s) {
  return {{"table", "paths"},
          {"engine", timed.engine->name()},
          {"mesh", body.name},
          {"triangles", body.triangles.size()},
          {"path", kStyles[s].name},
          {"us_median", Quantile(timed.styles[s].median_us, 0.5)},
          {"us_p99", Quantile(timed.styles[s].p99_us, 0.5)},
          {"us_p999", Quantile(timed.styles[s].p999_us, 0.5)}};
}

// Mean cost of a whole Step far from everything, or without a scene, ns.
double FarTip_ns(const haptics::Scene& scene) {
  constexpr int kCalls = 2000, kRounds = 25;
  haptics::State state;
  haptics::EnterScene(scene, state);
  const haptics::Config config = PlainConfig();
  haptics::Input input = PlainInput();
  haptics::Output output;
  input.device_point_base_m = {0, 0, 0.3};
  haptics::Step(config, scene, input, state, output);
  haptics::Step(config, scene, input, state, output);
  std::vector<double> ns;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint64_t begin = __rdtsc();
    for (int i = 0; i < kCalls; ++i) {
      input.device_point_base_m.x = 1e-3 * (i % 10);
      haptics::Step(config, scene, input, state, output);
    }
    ns.push_back(1e3 * static_cast<double>(__rdtsc() - begin) / TicksPerMicrosecond() / kCalls);
  }
  return Quantile(ns, 0.5);
}

ordered_json BuildRow(const Body& body, const haptics::Scene& scene, const haptics::BuildReport& report) {
  const auto n = static_cast<double>(body.triangles.size());
  return {{"table", "build"},
          {"mesh", body.name},
          {"triangles", body.triangles.size()},
          {"repair_ms", report.repair_ms},
          {"topology_ms", report.topology_ms},
          {"tree_ms", report.tree_ms},
          {"layout_ms", report.layout_ms},
          {"scene_ms", report.build_ms},
          {"mesh_bytes", static_cast<double>(scene.vertices().size_bytes()) / n},
          {"adjacency_and_tags_bytes", static_cast<double>(scene.triangles().size_bytes()) / n},
          {"tree_bytes", static_cast<double>(scene.nodes().size_bytes()) / n},
          {"far_tip_ns", FarTip_ns(scene)},
          {"no_scene_ns", FarTip_ns({})}};
}

ordered_json JudgeRow(const Body& body, const char* style, const Verdict& v) {
  return {{"table", "correctness"},
          {"mesh", body.name},
          {"triangles", body.triangles.size()},
          {"path", style},
          {"ticks", v.ticks},
          {"inside", v.inside},
          {"outside", v.outside},
          {"missed", v.missed},
          {"false_contacts", v.wrong},
          {"deepest_mm", 1e3 * v.deepest_m},
          {"direction_p99_deg", Quantile(v.direction_deg, 0.99)},
          {"oracle_checked", v.checked},
          {"oracle_wrong", v.oracle_wrong}};
}

void Merge(const Verdict& from, Verdict& to) {
  to.ticks += from.ticks;
  to.missed += from.missed;
  to.wrong += from.wrong;
  to.oracle_wrong += from.oracle_wrong;
  to.direction_deg.insert(to.direction_deg.end(), from.direction_deg.begin(), from.direction_deg.end());
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options) {}

  bool Run(const Body& body, std::uint64_t ticks) {
    std::cerr << body.name << ", " << body.triangles.size() << " triangles" << std::endl;
    if (!body.closed) std::cerr << "  not closed: nothing can be judged" << std::endl;
    std::vector<Timed> engines;
    std::optional<haptics::Scene> scene;
    haptics::BuildReport report;
    BuildCost cost;
    std::vector<double> build_ms;
    for (int k = 0; k < options_.builds; ++k) {
      auto built = haptics::BuildScene(SceneOf(body), report);
      if (!built.ok()) {
        std::cerr << "  " << built.error() << std::endl;
        return false;
      }
      scene = std::move(*built);
      build_ms.push_back(report.tree_ms);
    }
    cost.tree_bytes = static_cast<double>(scene->nodes().size_bytes());
    for (const OmniKind kind : {OmniKind::kProxy, OmniKind::kContact, OmniKind::kClosest, OmniKind::kClosestCold}) {
      Add(MakeOmni(kind, *scene, cost), body, engines);
      engines.back().build_ms = build_ms;
    }
    rows_.push_back(BuildRow(body, *scene, report));
    AddPeers(body, engines);
    const Oracle oracle(body);
    std::vector<std::vector<Vec3>> paths;
    Verdict all;
    const std::size_t timed_ticks = static_cast<std::size_t>(3 * options_.batches) * kBatch;
    for (std::size_t s = 0; s < std::size(kStyles); ++s) {
      const std::uint64_t per_style = ticks / std::size(kStyles);
      const std::uint64_t seed = 1'000'003 * options_.seed + 1009 * body.triangles.size() + s;
      std::vector<Vec3> path = MakePath(body, oracle, kStyles[s], std::max<std::size_t>(per_style, timed_ticks), seed);
      paths.emplace_back(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(timed_ticks));
      if (!body.closed) continue;
      path.resize(per_style);
      Verdict verdict;
      const std::uint64_t checks = std::min(Checks(body) / std::size(kStyles), per_style);
      JudgePath(body, oracle, *scene, path, checks > 0 ? per_style / checks : 0, verdict);
      rows_.push_back(JudgeRow(body, kStyles[s].name, verdict));
      Merge(verdict, all);
    }
    if (all.oracle_wrong > 0) std::cerr << "  the oracle contradicts sums over all triangles" << std::endl;
    TimeEngines(oracle, paths, options_, engines);
    for (const Timed& timed : engines) {
      const bool judged = body.closed && std::strcmp(timed.engine->name(), "omni-proxy") == 0;
      rows_.push_back(Row(body, timed, judged ? &all : nullptr));
    }
    for (std::size_t s = 0; s < std::size(kStyles); ++s) {
      for (const Timed& timed : engines) rows_.push_back(StyleRow(body, timed, s));
    }
    return true;
  }

  const std::vector<ordered_json>& rows() const { return rows_; }

 private:
  static void Add(std::unique_ptr<Engine> engine, const Body& body, std::vector<Timed>& engines) {
    Timed timed;
    timed.engine = std::move(engine);
    timed.cost = timed.engine->Build(body);
    timed.build_ms.push_back(timed.cost.build_ms);
    engines.push_back(std::move(timed));
  }

  // All of them in the long run; in others at most 2e9 pairs of point and triangle per body.
  std::uint64_t Checks(const Body& body) const {
    constexpr std::uint64_t kLongRun = 10'000'000, kPairs = 2'000'000'000;
    return options_.ticks >= kLongRun ? options_.checks : std::min(options_.checks, kPairs / body.triangles.size());
  }

  void AddPeers(const Body& body, std::vector<Timed>& engines) const {
    const auto add = [&](auto make) {
      std::unique_ptr<Engine> engine = make();
      if (!engine) return;
      Add(std::move(engine), body, engines);
    };
    add([] { return MakeEmbree(false); });
    add([] { return MakeEmbree(true); });
    add(MakeBullet);
    add(MakeFcl);
    add(MakeCgal);
    // Build times of the peer whose build is compared, measured as often as ours.
    for (Timed& timed : engines) {
      if (std::strncmp(timed.engine->name(), "embree", 6) != 0) continue;
      for (int k = 1; k < options_.builds; ++k) timed.build_ms.push_back(MakeEmbree(false)->Build(body).build_ms);
    }
  }

  Options options_;
  std::vector<ordered_json> rows_;
};

bool Parse(int count, char** words, Options& options) {
  for (int i = 1; i < count; ++i) {
    const std::string word = words[i];
    const char* const value = i + 1 < count ? words[i + 1] : nullptr;
    if (word == "--quick") {
      options.ticks = 10'000;
      options.checks = 200;
      options.batches = 2;
      options.builds = 1;
      options.largest = 100'000;
      continue;
    }
    if (value == nullptr) return false;
    ++i;
    if (word == "--seed") {
      options.seed = std::strtoull(value, nullptr, 10);
    } else if (word == "--ticks") {
      options.ticks = std::strtoull(value, nullptr, 10);
    } else if (word == "--triangles") {
      options.only = static_cast<std::uint32_t>(std::strtoul(value, nullptr, 10));
    } else if (word == "--gear") {
      options.only = static_cast<std::uint32_t>(std::strtoul(value, nullptr, 10));
      options.gear = true;
    } else if (word == "--mesh") {
      options.mesh = value;
    } else {
      return false;
    }
  }
  return true;
}

void SayMissingPeers() {
  if (!MakeEmbree(false)) std::cerr << "no rows of embree: libembree-dev was not found at configure time\n";
  if (!MakeBullet()) std::cerr << "no rows of bullet: libbullet-dev was not found at configure time\n";
  if (!MakeFcl()) std::cerr << "no rows of fcl: libfcl-dev was not found at configure time\n";
  if (!MakeCgal()) std::cerr << "no rows of cgal: libcgal-dev was not found at configure time\n";
}

int Main(int count, char** words) {
  Options options;
  if (!Parse(count, words, options)) {
    std::cerr << "usage: omni_bench_collision [--seed N] [--ticks N] [--mesh FILE.glb] [--triangles N | --gear N] "
                 "[--quick]\n";
    return 2;
  }
  SayMissingPeers();
  std::vector<Body> bodies;
  if (!options.mesh.empty()) {
    auto body = ReadGlb(options.mesh);
    if (!body.ok()) {
      std::cerr << body.error() << "\n";
      return 1;
    }
    bodies.push_back(std::move(*body));
  } else if (options.only > 0) {
    bodies.push_back(options.gear ? MakeGear(options.only) : MakeLump(options.only, options.seed));
  } else {
    for (const std::uint32_t n : {1'000U, 10'000U, 100'000U, 1'000'000U}) {
      if (n <= options.largest) bodies.push_back(MakeLump(n, options.seed));
    }
    for (const std::uint32_t n : {10'000U, 100'000U}) bodies.push_back(MakeGear(n));
  }
  Bench bench(options);
  for (const Body& body : bodies) {
    if (!bench.Run(body, options.ticks / bodies.size())) return 1;
  }
  bench::PrintRows(bench.rows());
  return 0;
}

}  // namespace
}  // namespace omni::collision

int main(int count, char** words) { return omni::collision::Main(count, words); }
