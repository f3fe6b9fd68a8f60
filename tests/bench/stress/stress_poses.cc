// How far off a start may be, and poses where something could divide by zero.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "service/config/files/device_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/sim/fields/vec3.h"
#include "tests/bench/stress/stress.h"
#include "tests/bench/tracking/static.h"
#include "tests/support/rig/rig.h"

namespace omni::bench {
namespace {

constexpr int kPosesPerKind = 200;
constexpr int kTicksPerPose = 30;
constexpr int kWarmIterations = 30;

base::Vec3 DrawUnit(sim::Random& random) { return Normalized(random.NormalVector(1)); }

// One direction that random axes never hit exactly.
struct SingularKind {
  const char* name;
  sim::MagnetPose (*draw)(sim::Random& random);
};

sim::MagnetPose PerpendicularToRadius(sim::Random& random) {
  base::Vec3 n = DrawUnit(random);
  n.z = std::abs(n.z);
  return {random.Uniform(0.055, 0.1) * n, sim::Rotated(sim::Perpendicular(n), random.Uniform(0, 6.28) * n)};
}
sim::MagnetPose StraightDownOnTheAxis(sim::Random& random) { return {{0, 0, random.Uniform(0.0411, 0.1)}, {0, 0, -1}}; }
sim::MagnetPose StraightUpOnTheAxis(sim::Random& random) { return {{0, 0, random.Uniform(0.0411, 0.1)}, {0, 0, 1}}; }
sim::MagnetPose AxisUpAnywhere(sim::Random& random) {
  base::Vec3 n = DrawUnit(random);
  n.z = std::abs(n.z);
  return {random.Uniform(0.055, 0.1) * n, {0, 0, 1}};
}
// Where a tangent basis changes its branch.
sim::MagnetPose AxisNearlyUp(sim::Random& random) {
  sim::MagnetPose pose = AxisUpAnywhere(random);
  pose.axis_base = Normalized(pose.axis_base + random.NormalVector(0.01));
  return pose;
}
sim::MagnetPose InTheBasePlane(sim::Random& random) {
  const double phi = random.Uniform(0, 2 * std::numbers::pi);
  const base::Vec3 n{std::cos(phi), std::sin(phi), 0};
  return {random.Uniform(0.055, 0.1) * n, -1.0 * n};
}
sim::MagnetPose AlongACoil(sim::Random& random) {
  const double r = random.Uniform(0.0411, 0.1);
  return {{r, 0, 0}, {random.Bits() & 1U ? 1.0 : -1.0, 0, 0}};
}
// Flat upon the hull: gap 0.
sim::MagnetPose InContact(sim::Random& random) {
  base::Vec3 n = DrawUnit(random);
  n.z = std::abs(n.z);
  const base::DeviceGeometry& device = config::DefaultDevice();
  return {(device.hull_radius_m + device.magnet.half_height_m + 1e-6) * n, -1.0 * n};
}

constexpr SingularKind kKinds[] = {
    {"pen perpendicular to the radius", PerpendicularToRadius},
    {"straight down on the z axis", StraightDownOnTheAxis},
    {"straight up on the z axis", StraightUpOnTheAxis},
    {"axis exactly +z", AxisUpAnywhere},
    {"axis about +z", AxisNearlyUp},
    {"in the base plane", InTheBasePlane},
    {"along coil x", AlongACoil},
    {"flat upon the hull", InContact},
};

// A vibration along the pen requests force whatever the scene.
loop::Commands Shake(const base::HallScan& scan) {
  return {.t_ns = scan.t_ns,
          .gate = loop::ForceGate::kOpen,
          .idle = false,
          .scene_generation = 1,
          .haptic = {.id = 1, .active = true, .duration_s = 1, .amplitude = 1, .frequency_Hz = 200}};
}

struct SingularTally {
  ErrorSet errors;
  double current_max_A = 0;
  std::uint64_t bad_currents = 0;  // not finite or over the limit
};

void HoldThere(const loop::TickConfig& config, sim::Rig& rig, const sim::MagnetPose& pose, sim::Random& random,
               SingularTally& tally) {
  const haptics::Scene scene;
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, 1, *state);
  // With the pen at rest the field is computed once; only the noise is new.
  for (int tick = 0; tick < kTicksPerPose; ++tick) {
    const base::HallScan scan = rig.Scan(&pose, {}, random);
    loop::Tick(config, scan, Shake(scan), scene, *state, *output);
    for (const double I : output->currents.current_A) {
      tally.bad_currents += std::abs(I) <= config.actuation.current_max_A ? 0 : 1;
      tally.current_max_A = std::max(tally.current_max_A, std::abs(I));
    }
  }
  if (output->tool.status == base::TrackingStatus::kTracking) {
    tally.errors.Add(ErrorOf(pose, output->tool.position_base_m, output->tool.axis_base));
  } else {
    tally.errors.AddMissing();
  }
}

}  // namespace

base::Result<BenchRows> StressBasins(std::uint64_t solves, std::uint64_t seed) {
  struct Start {
    const char* name;
    double offset_m, offset_rad;
  };
  constexpr double kDegree_rad = std::numbers::pi / 180;
  constexpr Start kStarts[] = {
      {"warm, 1 mm + 1 deg", 1e-3, kDegree_rad},        {"warm, 5 mm + 5 deg", 5e-3, 5 * kDegree_rad},
      {"warm, 10 mm + 10 deg", 1e-2, 10 * kDegree_rad}, {"warm, 20 mm + 20 deg", 2e-2, 20 * kDegree_rad},
      {"warm, 40 mm + 40 deg", 4e-2, 40 * kDegree_rad}, {"cold", 0, 0},
      {"cold, also below the base plane", 0, 0}};
  sim::Rig rig(config::DefaultDevice(), {.seed = seed, .sizes = sim::NoImperfections()});
  const tracker::Model model = tracker::MakeModel(rig.ExactCalibration());
  const auto solver = tracker::StaticSolver::Make(rig.ExactCalibration(), {});
  if (!solver.ok()) return base::Error{solver.error()};
  sim::Random random(seed);
  BenchRows rows;
  for (const Start& start : kStarts) {
    const bool below = std::string_view(start.name).find("below") != std::string_view::npos;
    const sim::PoseRange range{.elevation_min_rad = below ? -20 * kDegree_rad : 0, .tilt_max_rad = std::numbers::pi};
    std::uint64_t arrived = 0, refused = 0;
    for (std::uint64_t i = 0; i < solves; ++i) {
      const sim::MagnetPose truth = rig.DrawPose(range, random);
      const base::HallScan scan = rig.Scan(&truth, {}, random);
      if (start.offset_m > 0) {
        const base::Vec3 turn =
            start.offset_rad * sim::Rotated(sim::Perpendicular(truth.axis_base),
                                            random.Uniform(0, 2 * std::numbers::pi) * truth.axis_base);
        const tracker::Pose from{base::ToEigen(truth.centre_base_m + start.offset_m * DrawUnit(random)),
                                 base::ToEigen(sim::Rotated(truth.axis_base, turn))};
        const auto measurement = tracker::MakeMeasurement(model, tracker::NoiseOnly(), scan, {}, {});
        const tracker::Fit fit = SolvePose(model, measurement, from, 0, kWarmIterations);
        arrived += fit.converged && !ErrorOf(truth, fit.pose).failed() ? 1 : 0;
        continue;
      }
      const tracker::StaticPose solved = SolveScan(*solver, scan);
      arrived += HasPose(solved) && !ErrorOf(truth, solved.pose).failed() ? 1 : 0;
      refused += solved.status == tracker::StaticStatus::kFound ? 0 : 1;
    }
    rows.push_back({{"table", "basin"},
                    {"start", start.name},
                    {"n", solves},
                    {"arrived_pct", 100 * static_cast<double>(arrived) / static_cast<double>(solves)},
                    {"missed", solves - arrived},
                    {"refused", refused},
                    {"seed", seed}});
  }
  return rows;
}

BenchRows StressSingularPoses(std::uint64_t seed) {
  loop::FlushDenormals();
  sim::Rig rig(config::DefaultDevice(), {.seed = seed, .sizes = sim::NoImperfections()});
  loop::TickConfig config = loop::MakeTickConfig(config::DefaultDevice());
  config.tracker = tracker::MakeConfig(rig.ExactCalibration());
  sim::Random random(seed);
  BenchRows rows;
  for (const SingularKind& kind : kKinds) {
    SingularTally tally;
    for (int i = 0; i < kPosesPerKind; ++i) HoldThere(config, rig, kind.draw(random), random, tally);
    rows.push_back({{"table", "singular poses"},
                    {"pose", kind.name},
                    {"n", kPosesPerKind},
                    {"max_mm", tools::Quantile(tally.errors.position_mm, 1)},
                    {"orientation_max_deg", tools::Quantile(tally.errors.axis_deg, 1)},
                    {"over_2mm", tally.errors.LargerThan(kLarge_m)},
                    {"failures", tally.errors.failures},
                    {"bad_currents", tally.bad_currents},
                    {"current_max_A", tally.current_max_A},
                    {"seed", seed}});
  }
  return rows;
}

}  // namespace omni::bench
