// Scans of a virtual-time run with the loop closed, and their replay through Tick as often as wanted. The loop is
// deterministic, so a replay does exactly what the run did; the twin's time is left out.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/hall_scan.h"
#include "service/loop/tick.h"

namespace omni::tools {

// The hand script beside `scene_path` (a .glb) plays on the twin while `scene` is touched.
base::Result<std::vector<base::HallScan>> RecordScans(const loop::TickConfig& config, const haptics::Scene& scene,
                                                      const std::string& scene_path, std::uint64_t seed);

struct ReplayTiming {
  std::vector<double> us;  // of each tick
  std::uint64_t allocations = 0;
  std::uint64_t late = 0;  // ticks that alone took longer than their period
  std::uint64_t contact_ticks = 0;
};

ReplayTiming ReplayTicks(const loop::TickConfig& config, const haptics::Scene& scene,
                         const std::vector<base::HallScan>& scans, std::uint64_t ticks);

// One tick of the replay after another, for those who time it themselves.
class ScanPlayer {
 public:
  ScanPlayer(const loop::TickConfig& config, const haptics::Scene& scene, const std::vector<base::HallScan>& scans);

  void Tick() noexcept;
  const loop::TickOutput& output() const { return output_; }

 private:
  const loop::TickConfig& config_;
  const haptics::Scene& scene_;
  const std::vector<base::HallScan>& scans_;
  std::size_t next_ = 0;
  loop::LoopState state_;
  loop::TickOutput output_;
};

}  // namespace omni::tools
