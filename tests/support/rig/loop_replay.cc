#include "tests/support/rig/loop_replay.h"

#include <chrono>
#include <memory>

#include "service/base/limits.h"
#include "service/config/files/device_file.h"
#include "service/daemon/virtual_run.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/scene/scene.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/touch/fresh_scene.h"

namespace omni::test {

base::Result<loop::TickConfig> CalibratedTick(std::uint64_t seed) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto calibration = tools::KeptTwinCalibration(device, seed, "");
  if (!calibration.ok()) return base::Error{calibration.error()};
  return loop::MakeTickConfig(device, *calibration);
}

base::Result<std::vector<base::HallScan>> RecordScans(const loop::TickConfig& config, const haptics::Scene& scene,
                                                      const std::string& scene_path, std::uint64_t seed,
                                                      const base::TruthParameters& truth) {
  auto hand = sim::LoadHandScript(tools::FindHandScript(scene_path));
  if (!hand.ok()) return base::Error{hand.error()};
  const auto twin = sim::MakeVirtualTwin(config::DefaultDevice(), {.seed = seed, .script = *hand, .truth = truth},
                                         hand->duration_s());
  const haptics::Scene fresh = test::FreshCopy(scene);
  std::vector<base::HallScan> scans;
  daemon::RunVirtual(config, *twin, fresh, {},
                     [&](const base::HallScan& scan, const loop::TickOutput&) { scans.push_back(scan); });
  return scans;
}

ScanPlayer::ScanPlayer(const loop::TickConfig& config, const haptics::Scene& scene,
                       const std::vector<base::HallScan>& scans)
    : config_(config), scans_(scans), scene_(scene) {
  Start();
}

void ScanPlayer::Start() {
  if (next_ > 0) scene_.Renew();
  next_ = 0;
  state_ = loop::LoopState{};
  loop::EnterScene(scene_.scene(), 1, state_);
}

void ScanPlayer::Tick() noexcept {
  const base::HallScan& scan = scans_[next_++];
  const loop::Commands commands{
      .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
  loop::Tick(config_, scan, commands, scene_.scene(), state_, output_);
}

ReplayTiming ReplayTicks(const loop::TickConfig& config, const haptics::Scene& scene,
                         const std::vector<base::HallScan>& scans, std::uint64_t ticks) {
  using Clock = std::chrono::steady_clock;
  ReplayTiming timing;
  timing.us.resize(ticks);
  const auto player = std::make_unique<ScanPlayer>(config, scene, scans);
  for (double& us : timing.us) {
    if (player->at_end()) player->Start();
    const loop::AllocProbe probe;
    const Clock::time_point begin = Clock::now();
    player->Tick();
    const Clock::time_point end = Clock::now();
    timing.allocations += probe.count();
    us = std::chrono::duration<double, std::micro>(end - begin).count();
    timing.late += us > 1e6 * base::kTickPeriod_s ? 1 : 0;
    timing.contact_ticks += player->output().haptics.in_contact ? 1 : 0;
  }
  return timing;
}

}  // namespace omni::test
