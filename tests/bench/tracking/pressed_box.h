// What an ordinary hand presses in the benchmarks of tracking, and the whole loop while it does.
#pragma once

#include <cstdint>
#include <functional>

#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick.h"
#include "service/sim/twin/loopback.h"

namespace omni::bench {

// A box on the base, which the hand presses as it moves.
base::Result<haptics::Scene> PressedBox();

struct PressedTick {
  const base::HallScan& scan;
  const sim::TruthRow& truth;
  base::Vec3 magnet_base_m;        // its true centre at the scan's time
  bool pushed;                     // a force has acted on the pen since the scan before
  const loop::TickOutput& before;  // of the tick before
  const loop::TickOutput& output;
};

// The tick renders the scene, and the hand yields to the coils' true force. A simulation.
void Press(const base::DeviceGeometry& device, const loop::TickConfig& config, const base::TruthParameters& truth,
           std::uint64_t seed, const sim::HandScript& hand, double run_s, const haptics::Scene& scene,
           const std::function<void(const PressedTick&)>& use);

}  // namespace omni::bench
