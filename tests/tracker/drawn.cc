// A base that was never calibrated, as usually built, on a desk: the pen is there from the first scan, and the
// field around the base is unknown. Judged by the twin's truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "service/base/in_parallel.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "service/tracker/tracker.h"
#include "tests/support/hand/ordinary_hand.h"
#include "tests/support/rig/magnet_of_scan.h"

namespace omni::tracker {
namespace test_tracker_drawn {

using base::Vec3;

constexpr std::size_t kBases = 10;
constexpr double kFirst_s = 0.5;  // for the first pose

struct Tally {
  int scans = 0, posed = 0, silent = 0;
  double error_sum_mm = 0;
  double mean_mm() const { return error_sum_mm / std::max(1, posed); }
};

Tally Play(const base::TruthParameters& truth, std::uint64_t seed, const sim::HandScript& script, double run_s,
           double from_s = kFirst_s) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  sim::PlantOptions plant{.seed = seed, .script = script};
  plant.truth = truth;
  sim::Loopback base(device, plant);
  const Config config = MakeConfig(device);
  State state;
  base::ToolState tool;
  base::HallScan scan;
  Tally run;
  support::MagnetOfScan magnet({});
  for (int tick = 0; tick < 1000 * run_s; ++tick) {
    base.Tick(scan);
    Update(config, scan, state, tool);
    const sim::TruthRow now = base.core().Truth();
    const Vec3 centre_m = magnet.At(scan.t_ns, now);
    if (tick < 1000 * from_s) continue;
    ++run.scans;
    if (tool.status != base::TrackingStatus::kTracking) continue;
    ++run.posed;
    const double error_m = base::Norm(tool.position_base_m - centre_m);
    const auto& P = tool.covariance;
    run.silent += error_m > 5 * std::sqrt(P[0] + P[6] + P[12]) ? 1 : 0;
    run.error_sum_mm += 1e3 * error_m;
  }
  return run;
}

sim::HandScript Script(std::vector<sim::HandWaypoint> waypoints) { return {.waypoints = std::move(waypoints)}; }

// As the hands of the shipped scenes begin: at rest above the base, straight down.
sim::HandScript Above() {
  return Script({{.tip_base_m = {0, 0, 0.079}}, {.duration_s = 2, .tip_base_m = {0, 0, 0.079}}});
}
sim::HandScript Fast() {
  return Script({{.tip_base_m = {-0.06, 0, 0.04}},
                 {.duration_s = 0.35, .tip_base_m = {0.06, 0.01, 0.05}},
                 {.duration_s = 0.35, .tip_base_m = {0, -0.06, 0.05}},
                 {.duration_s = 1.3, .tip_base_m = {0, -0.06, 0.05}}});
}
sim::HandScript OnTheHull() {
  const double lying_m = config::DefaultDevice().hull_radius_m + config::DefaultDevice().magnet.radius_m;
  return Script({{.tip_base_m = {0, 0, lying_m}, .axis_base = {1, 0, 0}},
                 {.duration_s = 2, .tip_base_m = {0, 0, lying_m}, .axis_base = {1, 0, 0}}});
}
sim::HandScript Later() {
  return Script({{.tip_base_m = {0.05, 0, 0.06}, .present = false},
                 {.duration_s = 1.5, .tip_base_m = {0.05, 0, 0.06}, .present = false},
                 {.duration_s = 0.5, .tip_base_m = {0.02, 0, 0.05}},
                 {.duration_s = 1, .tip_base_m = {0.02, 0.01, 0.05}}});
}

struct Start {
  const char* name;
  sim::HandScript script;
  double from_s;
};

// Never found in 4 of 8 such bases, and 12 to 18 mm off with a deviation of 4 in the others, as long as a fit that just
// passed the gate counted as certain.
TEST(TrackerDrawn, PenIsFoundWithAnHonestDeviationHoweverItStarts) {
  const std::array<Start, 4> starts{{{"above", Above(), kFirst_s},
                                     {"fast", Fast(), kFirst_s},
                                     {"on the hull", OnTheHull(), kFirst_s},
                                     {"later", Later(), 2}}};
  for (const Start& start : starts) {
    std::array<Tally, kBases> runs;
    const double run_s = start.script.duration_s();
    base::InParallel(
        kBases, [&](std::size_t k) { runs[k] = Play(config::RoomTwin(), 101 + k, start.script, run_s, start.from_s); });
    int silent = 0, posed = 0;
    for (std::size_t k = 0; k < kBases; ++k) {
      EXPECT_GE(runs[k].posed, 0.98 * runs[k].scans) << start.name << ", base " << k;
      silent += runs[k].silent;
      posed += runs[k].posed;
    }
    EXPECT_LE(silent, 1e-3 * posed) << start.name;
  }
}

TEST(TrackerDrawn, MovingPenIsKnownToFourMillimetres) {
  std::array<Tally, kBases> runs;
  base::InParallel(kBases, [&](std::size_t k) {
    const sim::HandScript hand = sim::MakeOrdinaryHand(config::DefaultDevice(), {.seed = 201 + k, .duration_s = 6});
    runs[k] = Play(config::RoomTwin(), 101 + k, hand, 6);
  });
  double sum_mm = 0;
  int silent = 0, posed = 0;
  for (const Tally& run : runs) {
    EXPECT_GE(run.posed, 0.98 * run.scans);
    sum_mm += run.mean_mm() / static_cast<double>(kBases);
    silent += run.silent;
    posed += run.posed;
  }
  EXPECT_LE(sum_mm, 4);
  EXPECT_LE(silent, 1e-3 * posed);
}

// A base that is built as it was drawn is tracked as one: the tolerances are assumed only where they are needed.
TEST(TrackerDrawn, NominalBaseIsTrackedToTenthsOfAMillimetre) {
  const sim::HandScript hand = sim::MakeOrdinaryHand(config::DefaultDevice(), {.seed = 7, .duration_s = 4});
  const Tally run = Play(config::IdealTwin(), 3, hand, 4);
  EXPECT_EQ(run.posed, run.scans);
  EXPECT_LT(run.mean_mm(), 1);
}

}  // namespace test_tracker_drawn
}  // namespace omni::tracker
