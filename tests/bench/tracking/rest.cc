// Creep of the pose of a pen that lies still for ten minutes: bases calibrated on site, an ordinary hand for ten
// seconds, then nothing moves. Creep: change of the mean error over half a minute from that of the first half minute,
// which begins two seconds after the pen came to rest.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/config/files/twin_file.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "service/tracker/tracker.h"
#include "tests/bench/tracking/tracking.h"
#include "tests/support/hand/ordinary_hand.h"

namespace omni::bench {
namespace {

constexpr double kMoving_s = 10, kLying_s = 2, kRest_s = 600, kMean_s = 30;
constexpr std::size_t kRigs = 4;

constexpr std::array<const char*, 2> kWhere{"ideal", "room"};
constexpr std::array<double, 2> kRadii_m{0.055, 0.09};

sim::HandScript Hand(const base::DeviceGeometry& device, std::uint64_t seed, double radius_m, double rest_s) {
  sim::HandScript script = sim::MakeOrdinaryHand(device, {.seed = seed, .duration_s = kMoving_s, .tremor_m = 0});
  const base::Vec3 outwards = base::Normalized({0.4, 0.3, 1}), axis = -1.0 * outwards;
  const base::Vec3 tip = radius_m * outwards + device.magnet.tip_offset_m * axis;
  script.waypoints.push_back({.duration_s = 1, .tip_base_m = tip, .axis_base = axis});
  script.waypoints.push_back({.duration_s = rest_s + 1, .tip_base_m = tip, .axis_base = axis});
  return script;
}

struct Creep {
  double greatest_mm = 0, sigma_mm = 0;
  std::size_t lost = 0;
};

Creep LieStill(const base::DeviceGeometry& device, const tracker::Config& config, const base::TruthParameters& truth,
               std::uint64_t seed, double radius_m, double rest_s) {
  sim::PlantOptions plant{.seed = seed, .script = Hand(device, seed, radius_m, rest_s)};
  plant.truth = truth;
  const double begin_s = plant.script.duration_s() - rest_s + kLying_s - 1;
  sim::Loopback base(device, plant);
  tracker::State state;
  base::ToolState tool;
  base::HallScan scan;
  Creep creep;
  base::Vec3 first, sum;
  std::size_t n = 0, means = 0;
  const auto per_mean = static_cast<std::size_t>(kMean_s / base::kTickPeriod_s);
  for (auto tick = static_cast<std::size_t>((begin_s + rest_s - kLying_s) / base::kTickPeriod_s); tick > 0; --tick) {
    base.Tick(scan);
    tracker::Update(config, scan, state, tool);
    const sim::TruthRow truth_now = base.core().Truth();
    if (truth_now.t_ns < static_cast<std::int64_t>(1e9 * begin_s) + sim::Loopback::kClockStart_ns) continue;
    if (tool.status != base::TrackingStatus::kTracking) {
      ++creep.lost;
      continue;
    }
    sum = sum + (tool.position_base_m - truth_now.magnet_m);
    if (++n < per_mean) continue;
    const base::Vec3 mean = (1.0 / static_cast<double>(n)) * sum;
    if (means++ == 0) first = mean;
    creep.greatest_mm = std::max(creep.greatest_mm, 1e3 * base::Norm(mean - first));
    sum = {}, n = 0;
    creep.sigma_mm = 1e3 * std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
  }
  return creep;
}

}  // namespace

base::Result<BenchRows> Rest(const TrackingPlan& plan) {
  const std::size_t rigs = plan.share > 1 ? 1 : kRigs;
  const double rest_s = plan.share > 1 ? 93 : kRest_s;
  std::vector<std::array<Creep, kWhere.size() * kRadii_m.size()>> done(rigs);
  std::vector<std::string> failed(rigs);
  base::InParallel(rigs, [&](std::size_t r) {
    const std::uint64_t seed = 100 * plan.seeds.front() + 50 + r;
    for (std::size_t w = 0; w < kWhere.size(); ++w) {
      const base::TruthParameters truth = w == 0 ? config::IdealTwin() : config::RoomTwin();
      const auto config = SelfCalibrated(seed, truth);
      if (!config.ok()) {
        failed[r] = config.error();
        return;
      }
      for (std::size_t k = 0; k < kRadii_m.size(); ++k) {
        done[r][kRadii_m.size() * w + k] = LieStill(FastDevice(), *config, truth, seed, kRadii_m[k], rest_s);
      }
    }
  });
  for (const std::string& error : failed) {
    if (!error.empty()) return base::Error{error};
  }
  BenchRows rows;
  for (std::size_t place = 0; place < kWhere.size() * kRadii_m.size(); ++place) {
    std::vector<double> creep_mm, sigma_mm;
    std::size_t lost = 0;
    for (const auto& rig : done) {
      creep_mm.push_back(rig[place].greatest_mm);
      sigma_mm.push_back(rig[place].sigma_mm);
      lost += rig[place].lost;
    }
    rows.push_back({{"table", "rest"},
                    {"where", kWhere[place / kRadii_m.size()]},
                    {"radius_mm", 1e3 * kRadii_m[place % kRadii_m.size()]},
                    {"minutes", rest_s / 60},
                    {"creep_mean_mm", tools::Mean(creep_mm)},
                    {"creep_max_mm", tools::Quantile(creep_mm, 1)},
                    {"sigma_mm", tools::Mean(sigma_mm)},
                    {"lost_ticks", lost},
                    {"rigs", rigs},
                    {"seed", plan.seeds.front()}});
  }
  return rows;
}

}  // namespace omni::bench
