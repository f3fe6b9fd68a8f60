// A wall rendered through the whole tick on the digital twin: sensors, tracker, contact, coils. Worst of the rigs: rms
// of the coils' force above 30 Hz and of the tip in the last second, greatest force, total energy that the coils
// delivered to the pen.
#pragma once

#include <cstdint>
#include <functional>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin/loopback.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {

// A base, its host and the script's hand in virtual time until the script ends; `commands` are fresh in every tick.
void RunTwin(const base::DeviceGeometry& device, const loop::TickConfig& config, const sim::PlantOptions& plant,
             const haptics::Scene& scene, loop::Commands commands,
             const std::function<void(const sim::TruthRow&, const loop::TickOutput&)>& each_tick);

base::Result<BenchRows> ClosedLoop(std::uint64_t seed, bool quick);

}  // namespace omni::bench
