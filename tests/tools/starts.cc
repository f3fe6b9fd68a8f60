// Start of a service: the pen lies on the hull or approaches from afar, in a room whose field has changed since the
// calibration, or with the base turned. A simulated base, calibrated as by `omni calibrate`; compared with its truth.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tracker/tracker.h"
#include "tests/support/rig/magnet_of_scan.h"
#include "tests/support/rig/rig.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::test {
namespace test_tools_starts {

using base::TruthParameters;
using base::Vec3;

constexpr std::uint64_t kSeed = 5;
constexpr double kReach_m = 0.26;  // that of the tracker, and its error there

base::DeviceGeometry Device() {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = config::RoomTwin().sensor.noise_lp_T;
  return device;
}

// Once for all tests, and shorter than a person's.
const std::optional<tracker::Config>& Calibrated() {
  static const std::optional<tracker::Config> config = []() -> std::optional<tracker::Config> {
    const auto done = tools::CalibrateTwin(Device(), kSeed, config::RoomTwin(), {.wave_s = 6, .touches = 20});
    if (!done.ok()) return std::nullopt;
    return tracker::MakeConfig(done->outcome.calibration);
  }();
  return config;
}

Vec3 Direction(sim::Random& draw) { return Normalized(draw.NormalVector(1)); }

struct Change {
  const char* name;
  std::function<void(TruthParameters&, sim::Random&)> make;
};

Change Step(const char* name, double size_T) {
  return {name, [size_T](TruthParameters& truth, sim::Random& draw) {
            truth.effects.room.steps.push_back({.change_base_T = size_T * Direction(draw), .at_s = -1});
          }};
}

// The room turns the other way.
void Turn(TruthParameters& truth, sim::Random&) {
  const Vec3 turn_rad{0, 0, -30 * std::numbers::pi / 180};
  truth.effects.earth_field_base_T = sim::Rotated(truth.effects.earth_field_base_T, turn_rad);
  for (base::Steel& steel : truth.effects.room.steel) {
    steel.position_base_m = sim::Rotated(steel.position_base_m, turn_rad);
    steel.direction_base = sim::Rotated(steel.direction_base, turn_rad);
  }
}

std::vector<Change> Changes() {
  return {{"nothing", [](TruthParameters&, sim::Random&) {}},
          Step("20 uT", 20e-6),
          Step("60 uT", 60e-6),
          {"30 degrees", Turn}};
}

struct Start {
  double tracked_s = -1;  // first pose whose 3 sigma are within 3 mm
  double tracked_error_m = 0;
  double posed_at_m = 0;  // from here on every scan has a pose
  int silent = 0;         // poses off by more than 5 sigma
  int ghosts = 0;         // poses of a pen beyond reach, or of none
};

Start Play(const TruthParameters& truth, const sim::HandScript& script, double run_s) {
  sim::PlantOptions plant{.seed = kSeed, .script = script};
  plant.truth = truth;
  sim::Loopback base(Device(), plant);
  tracker::State state;
  base::ToolState tool;
  base::HallScan scan;
  support::MagnetOfScan magnet(base.core().Truth());
  Start start;
  bool posed = false;
  for (int tick = 0; tick < 1000 * run_s; ++tick) {
    base.Tick(scan);
    tracker::Update(*Calibrated(), scan, state, tool);
    const sim::TruthRow now = base.core().Truth();
    const Vec3 centre_m = magnet.At(scan.t_ns, now);
    const bool has_pose = tool.status == base::TrackingStatus::kTracking;
    if (has_pose && !posed) start.posed_at_m = base::Norm(centre_m);
    posed = has_pose;
    if (!has_pose) continue;
    const double sigma_m = std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
    const double error_m = base::Norm(tool.position_base_m - centre_m);
    start.silent += error_m > 5 * sigma_m ? 1 : 0;
    start.ghosts += !now.present || base::Norm(centre_m) > kReach_m ? 1 : 0;
    if (start.tracked_s < 0 && 3 * sigma_m <= 3e-3) {
      start.tracked_s = 1e-3 * tick;
      start.tracked_error_m = error_m;
    }
  }
  if (!posed) start.posed_at_m = 0;
  return start;
}

TEST(ToolsStarts, TracksPenOnTheHullWithin100Milliseconds) {
  ASSERT_TRUE(Calibrated());
  const base::DeviceGeometry device = Device();
  const sim::Rig rig(device, {.seed = kSeed, .sizes = config::RoomTwin().imperfections});
  sim::Random draw(1);
  for (const Change& change : Changes()) {
    for (int place = 0; place < 4; ++place) {
      SCOPED_TRACE(change.name);
      TruthParameters truth = config::RoomTwin();
      change.make(truth, draw);
      const sim::MagnetPose pose = OnHull(rig, rig.DrawPose({.tilt_max_rad = 1}, draw), 0);
      const Vec3 tip_m = pose.centre_base_m + device.magnet.tip_offset_m * pose.axis_base;
      const Start start = Play(truth, {.waypoints = {{0, tip_m, pose.axis_base, true}}}, 0.4);
      EXPECT_GE(start.tracked_s, 0);
      EXPECT_LE(start.tracked_s, 0.1);
      EXPECT_LT(start.tracked_error_m, 2e-3);
      EXPECT_EQ(start.silent, 0);
    }
  }
}

// Half a second in the hand first, then with .4 m/s on the average.
sim::HandScript BroughtFrom(double away_m, sim::Random& draw) {
  Vec3 from = Direction(draw);
  from.z = std::abs(from.z);
  const Vec3 to_m = 0.065 * Normalized(Vec3{draw.Uniform(-0.5, 0.5), draw.Uniform(-0.5, 0.5), 1.0});
  const Vec3 axis = Normalized(-1.0 * from + 0.5 * Direction(draw));
  return {.waypoints = {{0, away_m * from, axis, true},
                        {0.5, away_m * from, axis, true},
                        {away_m / 0.4, to_m, Normalized(-1.0 * to_m), true},
                        {0.2, to_m, Normalized(-1.0 * to_m), true}}};
}

TEST(ToolsStarts, ApproachingPenGivesNoFalsePoses) {
  ASSERT_TRUE(Calibrated());
  sim::Random draw(2);
  for (const Change& change : Changes()) {
    for (const double away_m : {0.3, 0.5, 1.0}) {
      SCOPED_TRACE(change.name);
      SCOPED_TRACE(away_m);
      TruthParameters truth = config::RoomTwin();
      change.make(truth, draw);
      const sim::HandScript script = BroughtFrom(away_m, draw);
      const Start start = Play(truth, script, script.duration_s());
      EXPECT_GE(start.posed_at_m, 0.08);
      EXPECT_GE(start.tracked_s, 0);
      EXPECT_LT(start.tracked_error_m, 4e-3);
      EXPECT_EQ(start.silent, 0);
      EXPECT_EQ(start.ghosts, 0);
    }
  }
}

TEST(ToolsStarts, NoFalsePosesWithoutAPen) {
  ASSERT_TRUE(Calibrated());
  sim::Random draw(3);
  for (const Change& change : Changes()) {
    SCOPED_TRACE(change.name);
    TruthParameters truth = config::RoomTwin();
    change.make(truth, draw);
    EXPECT_EQ(Play(truth, {}, 2).ghosts, 0);
  }
}

}  // namespace test_tools_starts
}  // namespace omni::test
