// omni-bench solver: run time and error of solvers on the same scans, one thread, problems built once. Batches of the
// methods take turns, so that a slow spell of the machine hits all of them.
#include "tests/bench/tracking/solver.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "service/loop/realtime.h"
#include "service/sim/fields/vec3.h"
#include "service/tracker/room/doubt.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/harness/timing.h"

namespace omni::bench {
namespace {

constexpr std::size_t kCases = 64;  // timed: few enough to stay in the cache, where a scan that was just made is
constexpr std::size_t kAccuracyCases = 20'000;
constexpr std::size_t kRounds = 200;  // of clean batches per method ...
constexpr std::size_t kTries = 3;     // ... if the system interrupts some
constexpr std::uint64_t kColdSolves = 1'000'000;
constexpr std::size_t kColdChunk = 20'000;
constexpr double kWarmOffset_m = 0.3e-3;
constexpr double kWarmOffset_rad = 0.5 * std::numbers::pi / 180;

const sim::PoseRange kAnyTilt{.tilt_max_rad = std::numbers::pi};

ErrorSet Judge(const SolverMethod& method, const std::vector<SolverCase>& cases) {
  ErrorSet errors;
  for (const SolverCase& one : cases) {
    const auto answer = method.solve(one);
    if (!answer) {
      errors.AddMissing();
      continue;
    }
    const PoseError error = ErrorOf(one.truth, answer->position_base_m, answer->axis_base);
    if (error.failed()) ++errors.failures;
    if (!error.failed()) errors.Add(error);
  }
  return errors;
}

void TimeInTurns(const std::vector<SolverMethod>& methods, const std::vector<SolverCase>& cases, std::size_t rounds,
                 std::vector<CallTimer>& timers) {
  for (std::size_t round = 0; round < rounds; ++round) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const auto call = [&](std::size_t i) { (void)methods[m].solve(cases[i % cases.size()]); };
      for (std::size_t attempt = 0; attempt < kTries && timers[m].batches() <= round; ++attempt) timers[m].Batch(call);
    }
  }
}

nlohmann::ordered_json Row(const SolverMethod& method, const CallTimer& timer, const ErrorSet& errors,
                           std::size_t count, std::uint64_t seed) {
  return {{"method", method.method},           {"model", method.model},          {"start", method.start},
          {"precision", method.precision},     {"us_median", timer.us_median()}, {"us_p99", timer.us_p99()},
          {"rms_mm", Rms(errors.position_mm)}, {"failures", errors.failures},    {"n", count},
          {"variant", method.variant},         {"batches", timer.batches()},     {"seed", seed}};
}

// A row per pair that the goals name.
void AddRatio(const char* what, const SolverMethod& slow, const CallTimer& slow_timer, const SolverMethod& fast,
              const CallTimer& fast_timer, BenchRows& rows) {
  const auto name = [](const SolverMethod& method) {
    return std::string(method.method) + " " + method.model + " " + method.start + " (" + method.variant + ")";
  };
  rows.push_back({{"table", "ratios"},
                  {"ratio", what},
                  {"value", slow_timer.us_median() / fast_timer.us_median()},
                  {"of", name(slow)},
                  {"to", name(fast)}});
}

// Ours in single precision with one step.
std::size_t FindSingleStep(const std::vector<SolverMethod>& methods) {
  const auto found = std::find_if(methods.begin(), methods.end(), [](const SolverMethod& method) {
    return method.model == std::string_view("full") && method.precision == std::string_view("float") &&
           method.variant == "1 step";
  });
  return static_cast<std::size_t>(found - methods.begin());
}

// The search for a failure takes poses of any tilt, drawn in pieces that fit in memory.
nlohmann::ordered_json SearchColdFailures(const SolverMethod& cold, const CallTimer& timer, sim::Rig& rig,
                                          const tracker::Config& product, std::uint64_t solves, std::uint64_t seed) {
  ErrorSet all;
  for (std::uint64_t done = 0, piece = 0; done < solves; ++piece) {
    const std::size_t count = std::min<std::uint64_t>(kColdChunk, solves - done);
    all.Add(Judge(cold, DrawSolverCases(rig, product, {kAnyTilt, count, seed + 1'000'000 * (piece + 1)})));
    done += count;
    if (piece % 5 == 4) std::cerr << "  " << done << " cold starts, " << all.failures << " failures\n";
  }
  SolverMethod any_tilt = cold;
  any_tilt.variant += ", any tilt";
  return Row(any_tilt, timer, all, solves, seed);
}

// For the first scan after the start, as in tracker::Update.
tracker::Trust FirstTrust(const tracker::Config& config) {
  return TrustIn(tracker::Doubt{.model_error = config.doubt.model_error_start}, config.trust);
}

}  // namespace

std::vector<SolverCase> DrawSolverCases(sim::Rig& rig, const tracker::Config& config, const SolverPoses& poses) {
  const tracker::Trust trust = FirstTrust(config);
  sim::Random random(poses.seed);
  std::vector<SolverCase> cases;
  cases.reserve(poses.count);
  for (std::size_t i = 0; i < poses.count; ++i) {
    const sim::MagnetPose truth = rig.DrawPose(poses.range, random);
    SolverCase one{.truth = truth, .scan = rig.Scan(&truth, {}, random)};
    one.measurement = tracker::MakeMeasurement(config.model, tracker::NoiseOnly(), one.scan, {}, {});
    one.product = tracker::MakeMeasurement(config.model, trust, one.scan, {}, {});
    one.peer = peers::MakePeerScan(one.measurement);
    const base::Vec3 turn = random.NormalVector(kWarmOffset_rad);
    one.warm = {base::ToEigen(truth.centre_base_m + random.NormalVector(kWarmOffset_m)),
                base::ToEigen(Normalized(truth.axis_base + base::Cross(turn, truth.axis_base)))};
    cases.push_back(one);
  }
  return cases;
}

base::Result<BenchRows> BenchSolver(const BenchOptions& options) {
  loop::FlushDenormals();
  const std::size_t share = options.quick ? 100 : 1;
  const std::uint64_t seed = ThreeSeeds(options.seed).front();
  sim::Rig rig(config::DefaultDevice(), {.seed = seed, .sizes = sim::NoImperfections()});
  const base::Calibration calibration = rig.ExactCalibration();
  const tracker::Config product = tracker::MakeConfig(calibration);
  std::vector<SolverMethod> methods = OmniSolvers(calibration, product);
  const std::size_t single_step = FindSingleStep(methods);
  const std::size_t ours = methods.size();
  for (SolverMethod& peer : PeerSolvers(calibration)) methods.push_back(std::move(peer));
  for (SolverMethod& paper : PaperSolvers(calibration)) methods.push_back(std::move(paper));

  std::cerr << "poses ...\n";
  const auto cases = DrawSolverCases(rig, product, {{}, kCases, seed});
  const auto more = DrawSolverCases(rig, product, {{}, std::max<std::size_t>(512, kAccuracyCases / share), seed + 1});
  std::cerr << "timing " << methods.size() << " methods ...\n";
  std::vector<CallTimer> timers(methods.size());
  TimeInTurns(methods, cases, std::max<std::size_t>(4, kRounds / share), timers);

  BenchRows rows;
  std::cerr << "errors ...\n";
  for (std::size_t m = 0; m < methods.size(); ++m) {
    rows.push_back(Row(methods[m], timers[m], Judge(methods[m], more), more.size(), seed));
  }
  const std::uint64_t solves = options.cold_solves > 0 ? options.cold_solves : kColdSolves / share;
  rows.push_back(SearchColdFailures(methods[1], timers[1], rig, product, solves, seed));
  for (std::size_t m = ours; m < methods.size(); ++m) {
    if (methods[m].start != std::string_view("warm")) continue;
    AddRatio("to the product's warm solve", methods[m], timers[m], methods[0], timers[0], rows);
  }
  // The starts are so close that one step is already within 1 % of the best rms error.
  for (std::size_t m = ours; m < methods.size(); ++m) {
    if (methods[m].start != std::string_view("warm")) continue;
    AddRatio("to our single step", methods[m], timers[m], methods[single_step], timers[single_step], rows);
  }
  AddRatio("cold to warm", methods[1], timers[1], methods[0], timers[0], rows);
  return rows;
}

}  // namespace omni::bench
