#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "tests/bench/tracking/nees.h"
#include "tests/bench/tracking/static.h"
#include "tests/bench/tracking/tracking.h"
#include "tests/support/rig/bound.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

using tracker::Rung;

constexpr std::size_t kModelPoses = 34'000;      // per seed: over 10^5 in all
constexpr std::size_t kEfficiencyPoses = 7'000;  // per seed: over 20,000
constexpr std::size_t kCurrentPoses = 7'000;     // per seed
constexpr std::size_t kBoundPoses = 150;         // per radius and seed
constexpr double kContactShare = 0.2;            // of the model error's poses touch the hull
const sim::PoseRange kAnyTilt{.tilt_max_rad = std::numbers::pi};

sim::Rig ExactRig(std::uint64_t seed, sim::NoiseMode noise, bool saturation) {
  return {config::DefaultDevice(),
          {.seed = seed, .sizes = sim::NoImperfections(), .noise = noise, .saturation = saturation}};
}

// Slides the magnet along its radius until it touches the hull.
sim::MagnetPose Touching(const sim::Rig& rig, const sim::MagnetPose& pose) {
  const base::DeviceGeometry& device = rig.device();
  const base::Vec3 outwards = base::Normalized(pose.centre_base_m);
  double inside = device.hull_radius_m, outside = base::Norm(pose.centre_base_m);
  sim::MagnetPose at = pose;
  while (outside - inside > 1e-9) {
    const double middle = 0.5 * (inside + outside);
    at.centre_base_m = middle * outwards;
    (GapToHull(device.magnet, device.hull_radius_m, at).gap_m >= 0 ? outside : inside) = middle;
  }
  at.centre_base_m = outside * outwards;
  return at;
}

double NeesOf(const sim::MagnetPose& truth, const tracker::StaticPose& fit) {
  std::array<double, 25> C{};
  Eigen::Map<Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(C.data()) = fit.covariance;
  return Nees(truth, base::FromEigen(fit.pose.position_base_m), base::FromEigen(fit.pose.axis_base), C);
}

double Square(double x) { return x * x; }

class EfficiencySum {
 public:
  void Add(sim::Rig& rig, const sim::MagnetPose& truth, const tracker::StaticPose& solved) {
    const sim::BoundOptions known{.noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh)};
    const auto bound = CramerRao(rig, truth, known);
    if (!HasPose(solved) || !bound) return;
    const PoseError error = ErrorOf(truth, solved.pose);
    ++found_;
    sum_.position += Square(error.position_m) / bound->position_m2;
    sum_.orientation += Square(error.axis_rad) / bound->orientation_rad2;
    sum_.nees += NeesOf(truth, solved);
  }
  // Of nothing: NaN.
  Efficiency Mean() const {
    const auto n = static_cast<double>(found_);
    return {sum_.position / n, sum_.orientation / n, sum_.nees / n};
  }

 private:
  Efficiency sum_;
  std::size_t found_ = 0;
};

// The least possible rms error at each radius, by further unknowns, mm; median / p95 over poses.
BenchRows BoundByRadius(const TrackingPlan& plan) {
  struct Unknown {
    const char* name;
    sim::BoundOptions options;
  };
  constexpr double kUnknown = sim::BoundOptions::kUnknown;
  const auto noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  const Unknown unknowns[] = {{"known", {.noise_T = noise_T}},
                              {"moment", {.noise_T = noise_T, .moment_prior = kUnknown}},
                              {"currents", {.noise_T = noise_T, .current_prior_A = kUnknown}},
                              {"ambient", {.noise_T = noise_T, .ambient_prior_T = kUnknown}}};
  BenchRows rows;
  constexpr int kRadii = 7;
  for (int step = 0; step < kRadii; ++step) {
    const double radius_m = 0.041 + 0.010 * step;
    std::array<std::vector<double>, std::size(unknowns)> position_mm;
    std::vector<double> axis_deg;
    for (const std::uint64_t seed : plan.seeds) {
      sim::Rig rig = ExactRig(seed, sim::NoiseMode::kUltraHigh, true);
      sim::Random random(seed + 1);
      for (std::size_t i = 0; i < std::max<std::size_t>(4, kBoundPoses / plan.share); ++i) {
        const sim::MagnetPose pose = rig.DrawPose({.radius_min_m = radius_m, .radius_max_m = radius_m + 1e-6}, random);
        for (std::size_t u = 0; u < std::size(unknowns); ++u) {
          const auto bound = CramerRao(rig, pose, unknowns[u].options);
          if (!bound) continue;
          position_mm[u].push_back(1e3 * std::sqrt(bound->position_m2));
          if (u == 0) axis_deg.push_back(std::sqrt(bound->orientation_rad2) * 180 / std::numbers::pi);
        }
      }
    }
    nlohmann::ordered_json row{{"table", "Cramer-Rao bound by radius"}, {"radius_mm", 1e3 * radius_m}};
    for (std::size_t u = 0; u < std::size(unknowns); ++u) {
      row[std::string(unknowns[u].name) + "_median_mm"] = tools::Quantile(position_mm[u], 0.5);
      row[std::string(unknowns[u].name) + "_p95_mm"] = tools::Quantile(position_mm[u], 0.95);
    }
    row["orientation_median_deg"] = tools::Quantile(axis_deg, 0.5);
    row["orientation_p95_deg"] = tools::Quantile(axis_deg, 0.95);
    row["seeds"] = SeedText(plan.seeds);
    rows.push_back(row);
  }
  return rows;
}

// The product's state after ten seconds of a waved pen, which is then taken away.
tracker::State WarmState(sim::Rig& rig, const tracker::Config& config, std::uint64_t seed) {
  sim::TraceOptions options{.duration_s = 10, .seed = seed};
  options.motion.seed = seed;
  tracker::State state;
  base::ToolState tool;
  for (const sim::TraceRow& row : sim::RecordTrace(rig, options)) tracker::Update(config, row.scan, state, tool);
  state.pose.warm = false;
  return state;
}

}  // namespace

base::Result<BenchRows> ModelErrors(const TrackingPlan& plan) {
  struct Study {
    const char* name;
    std::optional<Rung> rung;  // none: the product
    std::size_t poses;
  };
  const Study studies[] = {{"default", {}, kModelPoses},
                           {"noise-only", Rung::kFull, kModelPoses},
                           {"dipole-core", Rung::kDipoleCore, kModelPoses / 10},
                           {"dipole", Rung::kDipole, kModelPoses / 10}};
  BenchRows rows;
  for (const Study& study : studies) {
    ErrorSet errors;
    const std::size_t count = study.poses / plan.share;
    for (const std::uint64_t seed : plan.seeds) {
      sim::Rig rig = ExactRig(seed, sim::NoiseMode::kNone, false);
      base::Calibration calibration = rig.ExactCalibration();
      calibration.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);  // only weighs the axes
      const auto solver = tracker::StaticSolver::Make(calibration, {.rung = study.rung.value_or(Rung::kFull)});
      if (!solver.ok()) return base::Error{solver.error()};
      const tracker::Config product = tracker::MakeConfig(calibration);
      sim::Random random(seed);
      for (std::size_t i = 0; i < count; ++i) {
        sim::MagnetPose truth = rig.DrawPose(kAnyTilt, random);
        if (random.Uniform() < kContactShare) truth = Touching(rig, truth);
        const base::HallScan scan = rig.Scan(&truth, {}, random);
        AddSolved(truth, study.rung ? SolveScan(*solver, scan) : TrackScan(product, scan), errors);
      }
    }
    rows.push_back(TrackingRow({.model = study.name, .noise = "none"}, errors, count * plan.seeds.size(), plan.seeds));
  }
  return rows;
}

base::Result<BenchRows> Efficiencies(const TrackingPlan& plan) {
  BenchRows rows;
  for (const char* model : {"default", "default, warm", "noise-only"}) {
    const bool is_product = rows.size() < 2, is_warm = rows.size() == 1;
    ErrorSet errors;
    EfficiencySum sum;
    const std::size_t count = kEfficiencyPoses / plan.share;
    for (const std::uint64_t seed : plan.seeds) {
      sim::Rig rig = ExactRig(seed, sim::NoiseMode::kUltraHigh, true);
      const auto solver = tracker::StaticSolver::Make(rig.ExactCalibration(), {});
      if (!solver.ok()) return base::Error{solver.error()};
      const tracker::Config product = tracker::MakeConfig(rig.ExactCalibration());
      const tracker::State state = is_warm ? WarmState(rig, product, seed) : tracker::State{};
      sim::Random random(seed);
      for (std::size_t i = 0; i < count; ++i) {
        const sim::MagnetPose truth = rig.DrawPose({}, random);
        base::HallScan scan = rig.Scan(&truth, {}, random);
        if (is_warm) scan.t_ns = state.pose.filter_t_ns + 100'000'000;
        const tracker::StaticPose solved = is_product ? TrackScan(product, scan, state) : SolveScan(*solver, scan);
        AddSolved(truth, solved, errors);
        sum.Add(rig, truth, solved);
      }
    }
    rows.push_back(TrackingRow({.model = model}, errors, count * plan.seeds.size(), plan.seeds, sum.Mean()));
  }
  const BenchRows table = BoundByRadius(plan);
  rows.insert(rows.end(), table.begin(), table.end());
  return rows;
}

base::Result<BenchRows> UnderCurrent(const TrackingPlan& plan) {
  struct Case {
    TrackingConditions conditions;
    sim::NoiseMode noise;
  };
  const Case cases[] = {
      {{.model = "noise-only", .noise = "UHP", .actuation_A = 15, .currents = "hidden"}, sim::NoiseMode::kUltraHigh},
      {{.noise = "UHP", .actuation_A = 15}, sim::NoiseMode::kUltraHigh},
      {{.noise = "UHP", .actuation_A = 4}, sim::NoiseMode::kUltraHigh},
      {{.noise = "LP", .actuation_A = 0}, sim::NoiseMode::kLowPower},
      {{.noise = "LP", .actuation_A = 4}, sim::NoiseMode::kLowPower},
  };
  BenchRows rows;
  const std::size_t count = kCurrentPoses / plan.share;
  for (const Case& one : cases) {
    ErrorSet errors;
    const double limit_A = one.conditions.actuation_A;
    const bool hidden = one.conditions.currents == "hidden";
    for (const std::uint64_t seed : plan.seeds) {
      // Current sensors err by .15 % + 2 mA; hidden currents are never reported.
      sim::RigOptions options{.seed = seed, .sizes = sim::NoImperfections(), .noise = one.noise};
      options.sizes.current_gain = sim::ImperfectionSizes{}.current_gain;
      options.sizes.current_offset_A = sim::ImperfectionSizes{}.current_offset_A;
      sim::Rig rig(config::DefaultDevice(), options);
      tracker::Trust trust = tracker::NoiseOnly();
      trust.currents_hidden = true;
      const auto solver = tracker::StaticSolver::Make(rig.ExactCalibration(), {.trust = trust});
      if (!solver.ok()) return base::Error{solver.error()};
      const tracker::Config product = tracker::MakeConfig(rig.ExactCalibration());
      sim::Random random(seed);
      for (std::size_t i = 0; i < count; ++i) {
        const sim::MagnetPose truth = rig.DrawPose({}, random);
        sim::CoilArray current_A{};
        for (double& current : current_A) current = random.Uniform(-limit_A, limit_A);
        base::HallScan scan = rig.Scan(&truth, current_A, random);
        if (hidden) scan.coil_current_A = {};
        AddSolved(truth, hidden ? SolveScan(*solver, scan) : TrackScan(product, scan), errors);
      }
    }
    rows.push_back(TrackingRow(one.conditions, errors, count * plan.seeds.size(), plan.seeds));
  }
  return rows;
}

}  // namespace omni::bench
