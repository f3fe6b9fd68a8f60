// Scans of a virtual-time run with the loop closed, and their replay through Tick as often as wanted. The loop is
// deterministic, so a replay does exactly what the run did; the twin's time is left out. Sculpted surfaces are edited
// beside the replay, in real time, so that they follow the pen later than in the run; `scene` itself stays as it is.
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

// omnid's on the default twin with this seed, calibrated as omni does it: once, then from the cache folder.
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

// One tick of the replay after another, for those who time it themselves.
class ScanPlayer {
 public:
  // All three outlive the player. Precondition: there are scans.
  ScanPlayer(const loop::TickConfig& config, const haptics::Scene& scene, const std::vector<base::HallScan>& scans);

  bool at_end() const { return next_ == scans_.size(); }
  // From the first scan, in a scene that nobody has touched. Not to be timed: see FreshScene::Renew.
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
