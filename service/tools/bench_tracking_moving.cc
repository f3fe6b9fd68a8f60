// The paper's protocol on the twin: a pen waved within 10 cm, sawtooth currents in all coils, every fault that a base
// has. Rows differ by what the tracker knows of its base.
#include <array>
#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/config/device_file.h"
#include "service/magnetics/nominal.h"
#include "service/sim/trace.h"
#include "service/sim/vec3.h"
#include "service/tools/bench_tracking.h"
#include "service/tracker/tracker.h"

namespace omni::tools {
namespace {

using sim::operator+;
using sim::operator-;
using sim::operator*;

constexpr std::size_t kRigsPerSeed = 4;  // 12 in all
constexpr double kTrace_s = 20;
constexpr double kSettle_s = 0.2;
constexpr double kSawtooth_s = 0.5;
constexpr double kAmplitude_A = 4;

// A base as it comes from the workshop, and what happens to it during a run.
sim::RigOptions WorkshopRig(std::uint64_t seed) {
  sim::RigOptions options{.seed = seed, .noise = sim::NoiseMode::kLowPower};
  options.sizes.sensor_position_m = 1e-3;
  options.sizes.sensor_gain = 0.015;
  options.sizes.sensor_rotation_rad = 1.15 * std::numbers::pi / 180;
  options.effects.remanence_Am2 = 4e-3;
  options.effects.core_conductivity_S_m = 1e7;
  options.effects.ambient_drift_T = 5e-7;  // 5 mG
  options.effects.magnet_warming_K = 10;
  options.effects.run_s = kTrace_s;
  return options;
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

using Calibrate = base::Result<base::Calibration> (*)(sim::Rig& rig, std::uint64_t seed);

base::Result<base::Calibration> AsDrawn(sim::Rig& rig, std::uint64_t) {
  base::Calibration drawn = magnetics::NominalCalibration(rig.device());
  drawn.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kLowPower);
  return drawn;
}

base::Result<base::Calibration> Exact(sim::Rig& rig, std::uint64_t) { return rig.ExactCalibration(); }

}  // namespace

base::Result<BenchRows> PaperProtocol(const TrackingPlan& plan) {
  struct Case {
    const char* calibrated;
    Calibrate calibrate;
    double amplitude_A;
  };
  constexpr Case kCases[] = {{"exact", Exact, kAmplitude_A}, {"exact", Exact, 0}, {"none", AsDrawn, kAmplitude_A}};
  const std::size_t rigs = plan.share > 1 ? 1 : kRigsPerSeed;
  BenchRows rows;
  for (const Case& one : kCases) {
    RunErrors errors;
    for (const std::uint64_t seed : plan.seeds) {
      for (std::size_t r = 0; r < rigs; ++r) {
        const std::uint64_t rig_seed = 100 * seed + r;
        sim::Rig rig(config::DefaultDevice(), WorkshopRig(rig_seed));
        const auto calibration = one.calibrate(rig, rig_seed);
        if (!calibration.ok()) return base::Error{calibration.error()};
        sim::TraceOptions options{.duration_s = plan.share > 1 ? 2.0 : kTrace_s, .seed = rig_seed};
        options.motion.seed = rig_seed;
        if (one.amplitude_A > 0) options.currents = sim::StaggeredSawtooth(one.amplitude_A, kSawtooth_s);
        TrackTrace(tracker::MakeConfig(*calibration), sim::RecordTrace(rig, options), errors);
      }
    }
    nlohmann::ordered_json row =
        TrackingRow({.noise = "LP", .actuation_A = one.amplitude_A, .calibrated = one.calibrated, .moving = true},
                    errors.raw, errors.n, plan.seeds);
    row["aligned_mean_mm"] = Mean(errors.aligned_mm);
    row["aligned_p95_mm"] = Quantile(errors.aligned_mm, 0.95);
    row["rigs"] = rigs * plan.seeds.size();
    rows.push_back(row);
  }
  return rows;
}

}  // namespace omni::tools
