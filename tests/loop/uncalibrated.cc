// An uncalibrated base: sensors, windings, magnet, core and hull have manufacturing tolerances, while the tick assumes
// the nominal geometry. Whatever force is requested, the true force on the pen stays within the device's limit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <memory>

#include "service/config/files/device_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/sim/fields/vec3.h"
#include "tests/support/rig/rig.h"

namespace omni::test {
namespace test_loop_uncalibrated {

constexpr double kForceMax_N = 2;
constexpr int kPoses = 8, kTicks = 210, kFoundTicks = 30, kPushTicks = 60;
constexpr double kBeyondHull_m = 0.012;  // further out the coils cannot make 2 N

// What sensors do not see at once. Standard deviations: service/calibration/types.h, which measures such bases.
base::DeviceGeometry TolerancedDevice(sim::Random& random) {
  base::DeviceGeometry device = config::DefaultDevice();
  device.hull_radius_m += 0.1e-3 * random.Normal();
  device.core_radius_m *= 1 + 3e-3 * random.Normal();
  device.core_kappa = std::min(1.0, device.core_kappa * (1 + 0.01 * random.Normal()));
  return device;
}

// 1 mm, 1.5 % and 1.15 deg of the sensors times `share`. A base that has all of them is almost never tracked, and
// without tracking there is no force: those that are close enough to be tracked are the dangerous ones.
sim::ImperfectionSizes ToleranceSizes(double share) {
  sim::ImperfectionSizes sizes = sim::UncalibratedImperfections();
  sizes.sensor_position_m *= share;
  sizes.sensor_gain *= share;
  sizes.sensor_rotation_rad *= share;
  sizes.coil_strength = 5e-3;
  return sizes;
}

struct Pushed {
  int ticks = 0, driven = 0;
  double commanded_N = 0, true_N = 0;
};

// Requests 30 N in one direction after another; the pen is held still, the gate is open.
void PushAt(const loop::TickConfig& config, sim::Rig& rig, const sim::MagnetPose& pose, sim::Random& random,
            Pushed& pushed) {
  const haptics::Scene nothing;
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(nothing, 1, *state);
  state->gate = 1;
  loop::Commands commands{.gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
  commands.applied.open = true;
  const sim::ForceMap truth = rig.truth().ForcesAt(pose);
  for (int tick = 0; tick < kTicks; ++tick) {
    const base::HallScan scan = rig.Scan(&pose, output->currents.current_A, random);
    commands.t_ns = scan.t_ns;
    commands.applied.force_end_ns = scan.t_ns + 50'000'000;
    if (tick >= kFoundTicks && (tick - kFoundTicks) % kPushTicks == 0) {
      ++commands.applied.force_id;
      commands.applied.force_base_N = 30 * Normalized(random.NormalVector(1));
    }
    loop::Tick(config, scan, commands, nothing, *state, *output);
    const auto& current_A = output->currents.current_A;
    ++pushed.ticks;
    pushed.driven += current_A != sim::CoilArray{} ? 1 : 0;
    pushed.commanded_N = std::max(pushed.commanded_N, base::Norm(output->wrench.force_N));
    pushed.true_N = std::max(pushed.true_N, base::Norm(truth.Force(current_A, {})));
  }
}

Pushed PushTolerancedBases(double share, int bases) {
  const loop::TickConfig config = loop::MakeTickConfig(config::DefaultDevice());
  Pushed pushed;
  for (int i = 0; i < bases; ++i) {
    const auto seed = static_cast<std::uint64_t>(i + 1);
    sim::Random random(seed);
    sim::Rig rig(TolerancedDevice(random),
                 {.seed = seed, .sizes = ToleranceSizes(share), .noise = sim::NoiseMode::kLowPower});
    const double contact_m = rig.device().hull_radius_m + rig.device().magnet.half_height_m;
    const sim::PoseRange range{.radius_min_m = contact_m, .radius_max_m = contact_m + kBeyondHull_m, .tilt_max_rad = 1};
    for (int k = 0; k < kPoses; ++k) PushAt(config, rig, rig.DrawPose(range, random), random, pushed);
  }
  return pushed;
}

// Parameter: percent of the manufacturing tolerances.
class LoopUncalibrated : public testing::TestWithParam<int> {};

TEST_P(LoopUncalibrated, TrueForceStaysWithinTheDeviceLimit) {
  loop::FlushDenormals();
  const Pushed pushed = PushTolerancedBases(0.01 * GetParam(), 50);
  std::printf("driven in %2.0f %% of %d ticks, commanded %.3f N, true %.3f N\n", 100.0 * pushed.driven / pushed.ticks,
              pushed.ticks, pushed.commanded_N, pushed.true_N);
  EXPECT_LE(pushed.true_N, kForceMax_N);
  EXPECT_GT(pushed.driven, pushed.ticks / 5);
}

INSTANTIATE_TEST_SUITE_P(Percent, LoopUncalibrated, testing::Values(0, 5, 10, 15, 20, 30, 50, 100),
                         testing::PrintToStringParamName());

}  // namespace test_loop_uncalibrated
}  // namespace omni::test
