// The paper's protocol on the twin: a pen waved within 10 cm, sawtooth currents in all coils, every fault that a base
// has. Rows differ by what the tracker knows of its base.
#include <array>
#include <cmath>
#include <string>

#include "service/base/eigen.h"
#include "service/config/device_file.h"
#include "service/config/twin_file.h"
#include "service/sim/vec3.h"
#include "service/tools/calibrate_twin.h"
#include "service/tracker/tracker.h"
#include "tests/bench/tracking/tracking.h"
#include "tests/support/trace.h"

namespace omni::bench {
namespace {

using sim::operator+;
using sim::operator-;
using sim::operator*;
using sim::operator+=;

constexpr std::size_t kRigsPerSeed = 4;  // 12 in all
constexpr double kMovingTrace_s = 60;
constexpr double kCalibrating_s = 100;
constexpr double kSettle_s = 0.2;
constexpr double kSawtooth_s = 0.5;

// A base as it comes from the workshop, and everything that happens to the twin, faster than usual: the pen warms by 10
// K and the background drifts by its 5 mG within the run; while it is calibrated, within a hundred seconds.
base::TruthParameters HardTruth(double run_s) {
  base::TruthParameters truth = config::IdealTwin();
  const double nonlinearity = truth.imperfections.sensor_nonlinearity;
  truth.imperfections = sim::UncalibratedImperfections();
  truth.imperfections.sensor_nonlinearity = nonlinearity;
  truth.effects.magnet_warming_K = 10;
  truth.effects.run_s = run_s;
  return truth;
}

base::DeviceGeometry FastDevice() {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kLowPower);
  return device;
}

struct Pair {
  base::Vec3 truth, estimate;
};

// The rotation vector about the origin that brings the estimates closest to the truth, to first order of a small angle:
// sum (|x|^2 I - x x^T) w = sum x cross y. Errors here are below a degree.
base::Vec3 GlobalRotation(const std::vector<Pair>& pairs) {
  std::array<base::Vec3, 3> N{};
  base::Vec3 right;
  for (const Pair& pair : pairs) {
    const base::Vec3& x = pair.estimate;
    const double square = sim::Dot(x, x);
    N[0] += base::Vec3{square, 0, 0} - x.x * x;
    N[1] += base::Vec3{0, square, 0} - x.y * x;
    N[2] += base::Vec3{0, 0, square} - x.z * x;
    right += sim::Cross(x, pair.truth);
  }
  // Cramer's rule; N is symmetric.
  const double det = sim::Dot(N[0], sim::Cross(N[1], N[2]));
  return (1 / det) * base::Vec3{sim::Dot(right, sim::Cross(N[1], N[2])), sim::Dot(right, sim::Cross(N[2], N[0])),
                                sim::Dot(right, sim::Cross(N[0], N[1]))};
}

struct RunErrors {
  ErrorSet raw;
  std::vector<double> aligned_mm;
  std::size_t n = 0;
};

void TrackTrace(const tracker::Config& config, const std::vector<sim::TraceRow>& trace, RunErrors& errors) {
  tracker::State state;
  base::ToolState tool;
  std::vector<Pair> pairs;
  const auto settle = static_cast<std::size_t>(kSettle_s / base::kTickPeriod_s);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    tracker::Update(config, trace[i].scan, state, tool);
    if (i < settle) continue;
    ++errors.n;
    if (tool.status != base::TrackingStatus::kTracking) {
      errors.raw.AddMissing();
      continue;
    }
    errors.raw.Add(ErrorOf(trace[i].pose, tool.position_base_m, tool.axis_base));
    pairs.push_back({trace[i].pose.centre_base_m, tool.position_base_m});
  }
  const base::Vec3 turn = GlobalRotation(pairs);
  for (const Pair& pair : pairs) {
    errors.aligned_mm.push_back(1e3 * sim::Norm(sim::Rotated(pair.estimate, turn) - pair.truth));
  }
}

// What the tracker may know of its base, and what came of it at each amplitude.
constexpr std::array<const char*, 3> kKnowledge{"self", "exact", "none"};
constexpr std::array<double, 2> kAmplitudes_A{4, 0};

// The product's.
base::Result<std::array<tracker::Config, kKnowledge.size()>> Configs(const sim::Rig& rig, std::uint64_t seed) {
  const auto self = tools::CalibrateTwin(FastDevice(), seed, HardTruth(kCalibrating_s));
  if (!self.ok()) return base::Error{"rig " + std::to_string(seed) + ": " + self.error()};
  return std::array{tracker::MakeConfig(self->outcome.calibration), tracker::MakeConfig(rig.ExactCalibration()),
                    tracker::MakeConfig(FastDevice())};
}

}  // namespace

base::Result<BenchRows> PaperProtocol(const TrackingPlan& plan) {
  const std::size_t rigs = plan.share > 1 ? 1 : kRigsPerSeed;
  const double duration_s = plan.share > 1 ? 5.0 : kMovingTrace_s;
  std::array<std::array<RunErrors, kAmplitudes_A.size()>, kKnowledge.size()> all;
  for (const std::uint64_t seed : plan.seeds) {
    for (std::size_t r = 0; r < rigs; ++r) {
      const std::uint64_t rig_seed = 100 * seed + r;
      const base::TruthParameters truth = HardTruth(duration_s);
      sim::Rig rig(FastDevice(), {.seed = rig_seed,
                                  .sizes = truth.imperfections,
                                  .noise = sim::NoiseMode::kLowPower,
                                  .effects = truth.effects,
                                  .sensor = truth.sensor});
      const auto configs = Configs(rig, rig_seed);
      if (!configs.ok()) return base::Error{configs.error()};
      for (std::size_t a = 0; a < kAmplitudes_A.size(); ++a) {
        sim::TraceOptions options{.duration_s = duration_s, .seed = rig_seed};
        options.motion.seed = rig_seed;
        options.currents = sim::StaggeredSawtooth(kAmplitudes_A[a], kSawtooth_s);
        const std::vector<sim::TraceRow> trace = sim::RecordTrace(rig, options);
        for (std::size_t k = 0; k < kKnowledge.size(); ++k) {
          TrackTrace((*configs)[k], trace, all[k][a]);
        }
      }
    }
  }
  BenchRows rows;
  for (std::size_t k = 0; k < kKnowledge.size(); ++k) {
    for (std::size_t a = 0; a < kAmplitudes_A.size(); ++a) {
      const RunErrors& errors = all[k][a];
      nlohmann::ordered_json row =
          TrackingRow({.noise = "LP", .actuation_A = kAmplitudes_A[a], .calibrated = kKnowledge[k], .moving = true},
                      errors.raw, errors.n, plan.seeds);
      row["aligned_mean_mm"] = tools::Mean(errors.aligned_mm);
      row["aligned_p95_mm"] = tools::Quantile(errors.aligned_mm, 0.95);
      row["rigs"] = rigs * plan.seeds.size();
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace omni::bench
