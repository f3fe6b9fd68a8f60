// Scans of a virtual-time run with the loop closed, and any number of replays through Tick. The loop is deterministic,
// so a replay does exactly what the run did; the twin's time is excluded. Sculpted surfaces are edited in parallel, in
// real time, so that they follow the pen later than in the run; `scene` itself is not changed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/hall_scan.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/loop/tick.h"
#include "service/loop/tick_config.h"
#include "tests/support/touch/fresh_scene.h"

namespace omni::test {

// omnid's configuration for the default twin with this seed, calibrated as by omni: once, then from the cache folder.
base::Result<loop::TickConfig> CalibratedTick(std::uint64_t seed);

// The hand script beside `scene_path` (a .glb) plays on this twin while `scene` is touched.
base::Result<std::vector<base::HallScan>> RecordScans(const loop::TickConfig& config, const haptics::Scene& scene,
                                                      const std::string& scene_path, std::uint64_t seed,
                                                      const base::TruthParameters& truth);

struct ReplayTiming {
  std::vector<double> us;  // of each tick
  std::uint64_t allocations = 0;
  std::uint64_t late = 0;  // ticks that alone took longer than their period
  std::uint64_t contact_ticks = 0;
};

ReplayTiming ReplayTicks(const loop::TickConfig& config, const haptics::Scene& scene,
                         const std::vector<base::HallScan>& scans, std::uint64_t ticks);

// Plays one tick of the replay at a time, for callers that do their own timing.
class ScanPlayer {
 public:
  // All three outlive the player. Precondition: there are scans.
  ScanPlayer(const loop::TickConfig& config, const haptics::Scene& scene, const std::vector<base::HallScan>& scans);

  bool at_end() const { return next_ == scans_.size(); }
  // Restarts from the first scan, in an untouched scene. Not to be timed: see FreshScene::Renew.
  void Start();
  // Precondition: !at_end().
  void Tick() noexcept;
  const loop::TickOutput& output() const { return output_; }

 private:
  const loop::TickConfig& config_;
  const std::vector<base::HallScan>& scans_;
  FreshScene scene_;
  std::size_t next_ = 0;
  loop::LoopState state_;
  loop::TickOutput output_;
};

}  // namespace omni::test
