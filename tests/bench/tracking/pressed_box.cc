#include "tests/bench/tracking/pressed_box.h"

#include <memory>
#include <utility>

#include "tests/support/rig/magnet_of_scan.h"

namespace omni::bench {
namespace {

constexpr double kBox_m = 0.12, kBoxTop_m = 0.03;

}  // namespace

base::Result<haptics::Scene> PressedBox() {
  haptics::InputObject box;
  box.name = "box";
  for (const double z_m : {-0.02, kBoxTop_m}) {
    box.vertices_base_m.insert(
        box.vertices_base_m.end(),
        {{-kBox_m, -kBox_m, z_m}, {kBox_m, -kBox_m, z_m}, {kBox_m, kBox_m, z_m}, {-kBox_m, kBox_m, z_m}});
  }
  box.triangles = {{4, 5, 6}, {4, 6, 7}, {0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4},
                   {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  box.triangle_material.assign(box.triangles.size(), 0);
  haptics::SceneInput input;
  input.name = "box";
  input.materials.emplace_back();
  input.objects.push_back(std::move(box));
  haptics::BuildReport report;
  return haptics::BuildScene(input, report);
}

void Press(const base::DeviceGeometry& device, const loop::TickConfig& config, const base::TruthParameters& truth,
           std::uint64_t seed, const sim::HandScript& hand, double run_s, const haptics::Scene& scene,
           const std::function<void(const PressedTick&)>& use) {
  sim::PlantOptions plant{.seed = seed, .script = hand};
  plant.truth = truth;
  sim::Loopback base(device, plant);
  const auto state = std::make_unique<loop::LoopState>();
  auto before = std::make_unique<loop::TickOutput>(), output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, 1, *state);
  base::HallScan scan;
  support::MagnetOfScan magnet(base.core().Truth());
  for (auto ticks = static_cast<std::size_t>(run_s / base::kTickPeriod_s); ticks > 0; --ticks) {
    base.Tick(scan);
    const sim::TruthRow now = base.core().Truth();
    const bool pushed = state->limiter.last_N != base::Vec3{};
    const loop::Commands commands{
        .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
    std::swap(before, output);
    loop::Tick(config, scan, commands, scene, *state, *output);
    base.Write(output->currents);
    use({scan, now, magnet.At(scan.t_ns, now), pushed, *before, *output});
  }
}

}  // namespace omni::bench
