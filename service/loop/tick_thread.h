// The tick's thread: waits on a TickSource, calls Tick, sends the currents, publishes. Starts and stops off the tick.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>

#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/base/handover.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/scene_memory.h"
#include "service/loop/surface_snapshot.h"
#include "service/loop/telemetry.h"
#include "service/loop/tick.h"

namespace omni::loop {

// What clocks the loop: telemetry arrival, an absolute timer, or virtual time. Loop declares it, others implement it.
enum class WaitStatus : std::uint8_t { kTick = 0, kTimeout = 1, kGone = 2, kEnd = 3 };

class TickSource {
 public:
  virtual ~TickSource() = default;
  // Waits for the next tick and fills its scan. kTimeout: no telemetry within the source's own patience.
  virtual WaitStatus Wait(base::HallScan& scan) noexcept = 0;
  virtual void Apply(const base::CoilCurrents& currents) noexcept = 0;
};

// The scene that goes with Commands::scene_generation, a number that is never reused. The control thread owns every
// scene it handed over until TickStatistics::scene_generation names the newest one.
struct SceneRef {
  const haptics::Scene* scene = nullptr;  // null: empty
  std::uint64_t generation = 0;
  std::uint64_t build = 0;  // the same each time this scene is handed over: it comes back as it was left; 0: as built
};

class TickThread {
 public:
  struct Options {
    bool realtime = true;
    int priority = 80;
    bool telemetry = false;  // fill the ring (another thread drains it)
    int idle_divider = 16;   // with no client every n-th scan is ticked (62 Hz; within the device's 20 ms watchdog)
  };

  TickThread(const TickConfig& config, const Options& options, TickSource& source, TickSink& sink);
  ~TickThread();  // stops
  TickThread(const TickThread&) = delete;
  TickThread& operator=(const TickThread&) = delete;

  // Returns when the thread runs and real-time scheduling has been requested.
  void Start();
  void Stop();
  // Any thread: the coils go to zero and finished() becomes true after the current tick.
  void RequestStop() noexcept { stop_.store(true, std::memory_order_release); }

  // True when the source is gone or at its end: the thread has left its loop.
  bool finished() const noexcept { return finished_.load(std::memory_order_acquire); }
  WaitStatus end_status() const noexcept { return end_status_.load(std::memory_order_acquire); }

  base::Latest<Commands>& commands() noexcept { return commands_; }
  base::Latest<SceneRef>& scenes() noexcept { return scenes_; }
  // Keys of the keyboards and pedals that omnid may read; one writer at a time.
  base::Latest<base::KeyStates>& keys() noexcept { return keys_; }
  base::Latest<VibrationSamples>& vibration() noexcept { return *vibration_; }
  const TickStatistics& statistics() const noexcept { return *statistics_; }
  TelemetryRing& telemetry() noexcept { return *telemetry_; }
  base::Latest<tracker::RoomSample>& room() noexcept { return room_; }
  const RealtimeStatus& realtime() const noexcept { return realtime_; }  // after Start

  // Whether a client draws surfaces: only then are snapshots written. Any thread.
  void WantSurfaces(bool wanted) noexcept { surfaces_wanted_.store(wanted, std::memory_order_relaxed); }
  base::Latest<SurfaceSnapshot>& surfaces() noexcept { return *surfaces_; }

 private:
  void Run();
  void Once(const base::HallScan& scan) noexcept;
  void TakeScene(const Commands& commands) noexcept;
  std::int64_t OwnerSilence_ns(const OwnerLife& owner, std::int64_t now_ns) noexcept;
  void WriteSurfaces(std::int64_t t_ns) noexcept;
  void WriteRoom(const base::HallScan& scan) noexcept;

  const TickConfig config_;
  const Options options_;
  TickSource& source_;
  TickSink& sink_;
  base::Latest<Commands> commands_;
  base::Latest<SceneRef> scenes_;
  base::Latest<base::KeyStates> keys_;
  base::Latest<tracker::RoomSample> room_;
  std::unique_ptr<base::Latest<VibrationSamples>> vibration_;
  std::unique_ptr<TickStatistics> statistics_;
  std::unique_ptr<TelemetryRing> telemetry_;
  std::unique_ptr<base::Latest<SurfaceSnapshot>> surfaces_;
  std::atomic<bool> surfaces_wanted_{false};
  RealtimeStatus realtime_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> started_{false};
  std::atomic<bool> finished_{false};
  std::atomic<WaitStatus> end_status_{WaitStatus::kTick};
  std::thread thread_;
  // Tick thread only.
  LoopState state_;
  TickRecord record_;
  base::LifeWatch owner_watch_;
  std::uint64_t owner_number_ = 0;  // of the page that it reads
  const haptics::Scene empty_;
  const haptics::Scene* scene_ = &empty_;
  std::uint64_t build_ = 0;  // of scene_
  const std::unique_ptr<SceneMemory> memory_ = std::make_unique<SceneMemory>();
  std::int64_t surfaces_written_ns_ = 0, room_written_ns_ = 0;
};

}  // namespace omni::loop
