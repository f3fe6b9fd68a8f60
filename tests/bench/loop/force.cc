// omni-bench force: error of the force map against the twin's charges, by model and gap, and its cost. Truth: nominal
// sim::TruthModel, poses exactly at the gap from the hull, tilt up to 60 degrees from the radius.
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "service/actuation/actuation.h"
#include "service/config/files/device_file.h"
#include "service/loop/realtime.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/truth_model.h"
#include "service/sim/twin/twin.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/idle_timing.h"

namespace omni::bench {
namespace {

constexpr double kGaps_mm[] = {0, 5, 10, 20, 30, 60};
constexpr int kSeeds = 3;
constexpr int kPosesPerSeed = 700;
constexpr double kTiltCosine = 0.5;  // 60 degrees
constexpr int kBatches = 200;        // without involuntary switches of the thread
constexpr int kBatch = 1000;

struct TruePose {
  sim::MagnetPose pose;
  sim::ForceMap forces;
};

struct Model {
  const char* name;
  actuation::ForceModel model;
};

sim::Vec3 RandomUnit(sim::Random& random) { return base::Normalized(random.NormalVector(1)); }

// A random direction and axis; the distance at which the magnet is `gap_m` from the hull.
sim::MagnetPose DrawAtGap(const base::DeviceGeometry& device, double gap_m, sim::Random& random) {
  sim::Vec3 n = RandomUnit(random);
  n.z = std::abs(n.z);
  sim::MagnetPose pose;
  do {
    pose.axis_base = RandomUnit(random);
  } while (std::abs(base::Dot(pose.axis_base, n)) < kTiltCosine);
  double near_m = device.hull_radius_m, far_m = device.hull_radius_m + gap_m + 0.1;
  for (int i = 0; i < 60; ++i) {
    const double r = 0.5 * (near_m + far_m);
    pose.centre_base_m = r * n;
    (sim::GapToHull(device.magnet, device.hull_radius_m, pose).gap_m < gap_m ? near_m : far_m) = r;
  }
  return pose;
}

std::vector<TruePose> DrawPoses(const base::DeviceGeometry& device, double gap_m, std::uint64_t seed) {
  sim::TruthModel truth(device, sim::Imperfections{}, false);
  std::vector<TruePose> poses;
  for (int s = 0; s < kSeeds; ++s) {
    sim::Random random(seed + static_cast<std::uint64_t>(s));
    for (int i = 0; i < kPosesPerSeed; ++i) {
      const sim::MagnetPose pose = DrawAtGap(device, gap_m, random);
      poses.push_back({pose, truth.ForcesAt(pose)});
    }
  }
  return poses;
}

// The coil's radial force on top at contact is right, whatever it is elsewhere: the paper's use of a dipole law.
double ScaleToContact(const base::DeviceGeometry& device, const actuation::ForceModel& model) {
  const sim::MagnetPose pose{{0, 0, device.hull_radius_m + device.magnet.half_height_m}, {0, 0, 1}};
  sim::TruthModel truth(device, sim::Imperfections{}, false);
  const auto mapped =
      actuation::EvaluateForceMap(actuation::MakeForceMap(device, model), pose.centre_base_m, {0, 0, 1});
  return truth.ForcesAt(pose).coil[2].force_N.z / mapped.newton_per_ampere[8];
}

std::vector<Model> Models(const base::DeviceGeometry& device) {
  using actuation::MagnetDetail;
  constexpr actuation::ForceModel kDipole{.orders = 1, .magnet = MagnetDetail::kPoint};
  actuation::ForceModel scaled = kDipole;
  scaled.scale = ScaleToContact(device, kDipole);
  return {{"default", {}},
          {"dipole", kDipole},
          {"dipole-scaled", scaled},
          {"zonal7+point", {.orders = 4, .magnet = MagnetDetail::kPoint}},
          {"zonal7+ring5", {.orders = 4, .magnet = MagnetDetail::kRing}},
          {"zonal7+full", {.orders = 4, .magnet = MagnetDetail::kFull}},
          {"zonal13+ring5", {.magnet = MagnetDetail::kRing}}};
}

struct Errors {
  std::vector<double> map_pct, snapping_pct, torque_pct;
};

Errors Compare(const actuation::ForceMap& map, const std::vector<TruePose>& poses) {
  Errors errors;
  for (const TruePose& at : poses) {
    const auto mapped = actuation::EvaluateForceMap(map, at.pose.centre_base_m, at.pose.axis_base);
    double wrong = 0, all = 0, torque_wrong = 0, torque_all = 0;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      const sim::Vec3& F = at.forces.coil[k].force_N;
      const sim::Vec3& T = at.forces.coil[k].torque_Nm;
      const double force[3] = {F.x, F.y, F.z}, torque[3] = {T.x, T.y, T.z};
      for (std::size_t i = 0; i < 3; ++i) {
        wrong += std::pow(mapped.newton_per_ampere[3 * i + k] - force[i], 2);
        all += force[i] * force[i];
        torque_wrong += std::pow(mapped.newton_metre_per_ampere[3 * i + k] - torque[i], 2);
        torque_all += torque[i] * torque[i];
      }
    }
    const sim::Vec3 pull = at.forces.core.force_N;
    const sim::Vec3 mapped_pull{mapped.snapping_N.x, mapped.snapping_N.y, mapped.snapping_N.z};
    errors.map_pct.push_back(100 * std::sqrt(wrong / all));
    errors.torque_pct.push_back(100 * std::sqrt(torque_wrong / torque_all));
    errors.snapping_pct.push_back(100 * base::Norm(mapped_pull - pull) / base::Norm(pull));
  }
  return errors;
}

// Scans of a pen that comes down to 5 mm above the hull, goes round it and leaves again; coils at rest.
std::vector<base::HallScan> RecordScans(std::uint64_t seed) {
  sim::HandScript script;
  script.name = "round the hull";
  script.waypoints = {{.duration_s = 0, .tip_base_m = {0, 0, 0.090}},
                      {.duration_s = 1.0, .tip_base_m = {0, 0, 0.042}},
                      {.duration_s = 1.0, .tip_base_m = {0.040, 0, 0.030}, .axis_base = {-0.6, 0, -0.8}},
                      {.duration_s = 1.0, .tip_base_m = {0, 0.045, 0.040}, .axis_base = {0.3, -0.5, -0.8}},
                      {.duration_s = 1.0, .tip_base_m = {-0.030, -0.020, 0.060}}};
  const auto twin =
      sim::MakeVirtualTwin(config::DefaultDevice(), {.seed = seed, .script = script}, script.duration_s());
  std::vector<base::HallScan> scans;
  for (base::HallScan scan; twin->Read(scan, 0) == device::ReadStatus::kScan;) {
    scans.push_back(scan);
    twin->Write({});
  }
  return scans;
}

// A request that turns and swells, so that the coils are alternately within and beyond their limits.
base::Vec3 Request(std::uint64_t tick) {
  const double t = 1e-3 * static_cast<double>(tick);
  const double size_N = 2 + 1.5 * std::sin(7 * t);
  return {size_N * std::cos(3 * t), size_N * std::sin(3 * t), size_N * std::sin(11 * t)};
}

nlohmann::ordered_json TimingRow(const std::string& stage, const IdleTiming& timing) {
  return {{"model", "timing"},
          {"gap_mm", nullptr},
          {"error_median_pct", nullptr},
          {"error_p95_pct", nullptr},
          {"snapping_error_pct", nullptr},
          {"torque_error_pct", nullptr},
          {"n", timing.quiet_batches * kBatch},
          {"seeds", nullptr},
          {"stage", stage},
          {"us_median", timing.us_median},
          {"us_p99", timing.us_p99}};
}

// False: a stage returned a value that is not finite.
bool TimeStages(const base::DeviceGeometry& device, const std::vector<base::HallScan>& scans, BenchRows& rows) {
  loop::FlushDenormals();
  const tracker::Config tracker_config = tracker::MakeConfig(device);
  const actuation::Config config = actuation::MakeConfig(device);

  // All stages are timed on the poses that the tracker finds in the recording.
  const auto tracked = std::make_unique<tracker::State>();
  std::vector<base::ToolState> tools(scans.size());
  std::vector<base::ForceLimit> limits(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    tracker::Update(tracker_config, scans[i], *tracked, tools[i]);
    limits[i] = actuation::ComputeForceLimit(config, tools[i], {25, 25, 25});
  }
  double kept = 0;  // results are used
  rows.push_back(
      TimingRow("map", TimeWhenIdle(kBatches, kBatch, 4, [&](std::uint64_t i) {
                  const base::ToolState& tool = tools[i % tools.size()];
                  kept += actuation::EvaluateForceMap(config.map, tool.position_base_m, tool.axis_base).snapping_N.x;
                })));
  rows.push_back(
      TimingRow("map+limit", TimeWhenIdle(kBatches, kBatch, 4, [&](std::uint64_t i) {
                  kept += actuation::ComputeForceLimit(config, tools[i % tools.size()], {25, 25, 25}).conditioning;
                })));
  actuation::State state;
  base::CoilCurrents currents;
  rows.push_back(TimingRow("allocate, direction kept", TimeWhenIdle(kBatches, kBatch, 4, [&](std::uint64_t i) {
                             actuation::Allocate(config, limits[i % tools.size()], Request(i), 1e-3, state, currents);
                             kept += currents.current_A[0];
                           })));
  rows.push_back(TimingRow("track+map+allocate", TimeWhenIdle(kBatches, kBatch, 1, [&](std::uint64_t i) {
                             if (i % scans.size() == 0) *tracked = tracker::State{};
                             const base::HallScan& scan = scans[i % scans.size()];
                             base::ToolState tool;
                             tracker::Update(tracker_config, scan, *tracked, tool);
                             actuation::UpdateHeat(config, scan, state);
                             const base::ForceLimit limit = actuation::ComputeDeratedLimit(config, tool, state.heat);
                             actuation::Allocate(config, limit, Request(i), 1e-3, state, currents);
                             kept += currents.current_A[1];
                           })));
  return std::isfinite(kept);
}

}  // namespace

base::Result<BenchRows> BenchForce(const BenchOptions& options) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  std::string seeds;
  for (int s = 0; s < kSeeds; ++s) {
    seeds += (s > 0 ? "," : "") + std::to_string(options.seed + static_cast<std::uint64_t>(s));
  }
  BenchRows rows;
  std::vector<std::vector<TruePose>> poses;
  for (const double gap_mm : kGaps_mm) poses.push_back(DrawPoses(device, 1e-3 * gap_mm, options.seed));
  for (const Model& model : Models(device)) {
    const actuation::ForceMap map = actuation::MakeForceMap(device, model.model);
    for (std::size_t g = 0; g < poses.size(); ++g) {
      const Errors errors = Compare(map, poses[g]);
      rows.push_back({{"model", model.name},
                      {"gap_mm", kGaps_mm[g]},
                      {"error_median_pct", tools::Quantile(errors.map_pct, 0.5)},
                      {"error_p95_pct", tools::Quantile(errors.map_pct, 0.95)},
                      {"snapping_error_pct", tools::Quantile(errors.snapping_pct, 0.5)},
                      {"torque_error_pct", tools::Quantile(errors.torque_pct, 0.5)},
                      {"n", poses[g].size()},
                      {"seeds", seeds},
                      {"stage", nullptr},
                      {"us_median", nullptr},
                      {"us_p99", nullptr}});
    }
  }
  if (!TimeStages(device, RecordScans(options.seed), rows))
    return base::Error{"a stage returned currents that are not finite"};
  return rows;
}

}  // namespace omni::bench
