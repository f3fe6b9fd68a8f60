// The paper's protocol on the twin: a pen waved within 10 cm, sawtooth currents in all coils, every fault of a base.
// Rows differ by the tracker's calibration.
#include <array>
#include <cmath>
#include <string>

#include "service/base/in_parallel.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/fields/vec3.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tracker/tracker.h"
#include "tests/bench/tracking/nees.h"
#include "tests/bench/tracking/tracking.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr std::size_t kRigsPerSeed = 4;  // 12 in all
constexpr double kMovingTrace_s = 60;
constexpr double kCalibrating_s = 100;
constexpr double kSettle_s = 0.2, kWarm_s = 10;
constexpr double kSawtooth_s = 0.5;

// A base as usually built, with all effects of the twin, faster than usual: the pen warms by 10 K and the background
// drifts by its 5 mG within the run; during calibration, within a hundred seconds.
base::TruthParameters HardTruth(double run_s) {
  base::TruthParameters truth = config::IdealTwin();
  const double nonlinearity = truth.imperfections.sensor_nonlinearity;
  truth.imperfections = sim::UncalibratedImperfections();
  truth.imperfections.sensor_nonlinearity = nonlinearity;
  truth.effects.magnet_warming_K = 10;
  truth.effects.run_s = run_s;
  return truth;
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
    const double square = base::Dot(x, x);
    N[0] += base::Vec3{square, 0, 0} - x.x * x;
    N[1] += base::Vec3{0, square, 0} - x.y * x;
    N[2] += base::Vec3{0, 0, square} - x.z * x;
    right += base::Cross(x, pair.truth);
  }
  // Cramer's rule; N is symmetric.
  const double det = base::Dot(N[0], base::Cross(N[1], N[2]));
  return (1 / det) * base::Vec3{base::Dot(right, base::Cross(N[1], N[2])), base::Dot(right, base::Cross(N[2], N[0])),
                                base::Dot(right, base::Cross(N[0], N[1]))};
}

struct RunErrors {
  ErrorSet raw;
  std::vector<double> aligned_mm;
  std::vector<double> nees;  // of each base, mean once it is warm
  std::size_t n = 0;

  void Add(const RunErrors& other) {
    raw.Add(other.raw);
    Append(other.aligned_mm, aligned_mm);
    Append(other.nees, nees);
    n += other.n;
  }
};

void TrackTrace(const tracker::Config& config, const std::vector<sim::TraceRow>& trace, RunErrors& errors) {
  tracker::State state;
  base::ToolState tool;
  std::vector<Pair> pairs;
  std::vector<double> nees;
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
    if (static_cast<double>(i) * base::kTickPeriod_s < kWarm_s) continue;
    nees.push_back(Nees(trace[i].pose, tool.position_base_m, tool.axis_base, tool.covariance));
  }
  if (!nees.empty()) errors.nees.push_back(tools::Mean(nees));
  const base::Vec3 turn = GlobalRotation(pairs);
  for (const Pair& pair : pairs) {
    errors.aligned_mm.push_back(1e3 * base::Norm(sim::Rotated(pair.estimate, turn) - pair.truth));
  }
}

constexpr std::array<double, 2> kAmplitudes_A{4, 0};
using ByAmplitude = std::array<RunErrors, kAmplitudes_A.size()>;

// A base and the tracker's configurations for it, those of the product.
struct Knowledge {
  const char* name;
  tracker::Config config;
};

void TrackBase(sim::Rig& rig, std::uint64_t seed, double duration_s, const std::vector<Knowledge>& knowledge,
               std::vector<ByAmplitude>& errors) {
  for (std::size_t a = 0; a < kAmplitudes_A.size(); ++a) {
    sim::TraceOptions options{.duration_s = duration_s, .seed = seed};
    options.motion.seed = seed;
    options.currents = sim::StaggeredSawtooth(kAmplitudes_A[a], kSawtooth_s);
    const std::vector<sim::TraceRow> trace = sim::RecordTrace(rig, options);
    for (std::size_t k = 0; k < knowledge.size(); ++k) TrackTrace(knowledge[k].config, trace, errors[k][a]);
  }
}

sim::Rig MakeRig(std::uint64_t seed, const base::TruthParameters& truth) {
  return {FastDevice(), sim::OptionsOf(seed, sim::NoiseMode::kLowPower, truth)};
}

void AddRows(const char* calibrated, bool room, const ByAmplitude& errors, const TrackingPlan& plan, BenchRows& rows) {
  for (std::size_t a = 0; a < kAmplitudes_A.size(); ++a) {
    const RunErrors& run = errors[a];
    nlohmann::ordered_json row = TrackingRow(
        {.noise = "LP", .actuation_A = kAmplitudes_A[a], .calibrated = calibrated, .moving = true, .room = room},
        run.raw, run.n, plan.seeds);
    row["nees_per_dof"] = tools::Mean(run.nees);
    row["nees_least"] = tools::Quantile(run.nees, 0);
    row["nees_greatest"] = tools::Quantile(run.nees, 1);
    row["aligned_mean_mm"] = tools::Mean(run.aligned_mm);
    row["aligned_p95_mm"] = tools::Quantile(run.aligned_mm, 0.95);
    row["rigs"] = run.nees.size();
    rows.push_back(row);
  }
}

}  // namespace

base::Result<tracker::Config> SelfCalibrated(std::uint64_t seed, const base::TruthParameters& truth) {
  const auto self = tools::CalibrateTwin(FastDevice(), seed, truth);
  if (!self.ok()) return base::Error{"rig " + std::to_string(seed) + ": " + self.error()};
  return tracker::MakeConfig(self->outcome.calibration);
}

base::Result<BenchRows> PaperProtocol(const TrackingPlan& plan) {
  const std::size_t rigs = plan.share > 1 ? 1 : kRigsPerSeed;
  const double duration_s = plan.share > 1 ? 12.0 : kMovingTrace_s;
  const std::size_t count = rigs * plan.seeds.size();
  constexpr std::array<const char*, 3> kKnown{"self", "exact", "none"};
  std::vector<std::vector<ByAmplitude>> done(count, std::vector<ByAmplitude>(kKnown.size() + 1));
  std::vector<std::string> failed(count);
  base::InParallel(count, [&](std::size_t n) {
    const std::uint64_t seed = 100 * plan.seeds[n / rigs] + n % rigs;
    sim::Rig rig = MakeRig(seed, HardTruth(duration_s));
    const auto self = SelfCalibrated(seed, HardTruth(kCalibrating_s));
    const auto in_room = SelfCalibrated(seed, config::RoomTwin());
    if (!self.ok() || !in_room.ok()) {
      failed[n] = self.ok() ? in_room.error() : self.error();
      return;
    }
    TrackBase(rig, seed, duration_s,
              {{kKnown[0], *self},
               {kKnown[1], tracker::MakeConfig(rig.ExactCalibration())},
               {kKnown[2], tracker::MakeConfig(FastDevice())}},
              done[n]);
    sim::Rig room = MakeRig(seed, config::RoomTwin());
    std::vector<ByAmplitude> there(1);
    TrackBase(room, seed, duration_s, {{"self", *in_room}}, there);
    done[n].back() = there.front();
  });
  for (const std::string& error : failed) {
    if (!error.empty()) return base::Error{error};
  }
  std::vector<ByAmplitude> all(kKnown.size() + 1);
  for (const std::vector<ByAmplitude>& base : done) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      for (std::size_t a = 0; a < kAmplitudes_A.size(); ++a) all[k][a].Add(base[k][a]);
    }
  }
  BenchRows rows;
  for (std::size_t k = 0; k < kKnown.size(); ++k) AddRows(kKnown[k], false, all[k], plan, rows);
  AddRows("self", true, all.back(), plan, rows);
  return rows;
}

}  // namespace omni::bench
