#include "service/loop/tick_thread.h"

#include "service/base/clock.h"
#include "service/base/threads/realtime_threads.h"
#include "service/loop/realtime.h"

namespace omni::loop {
TickThread::TickThread(const TickConfig& config, const Options& options, TickSource& source, TickSink& sink)
    : config_(config),
      options_(options),
      source_(source),
      sink_(sink),
      vibration_(std::make_unique<base::Latest<VibrationSamples>>()),
      statistics_(std::make_unique<TickStatistics>()),
      telemetry_(std::make_unique<TelemetryRing>()),
      surfaces_(std::make_unique<base::Latest<SurfaceSnapshot>>()) {}

TickThread::~TickThread() { Stop(); }

void TickThread::Start() {
  thread_ = std::thread([this] { Run(); });
  started_.wait(false, std::memory_order_acquire);
}

void TickThread::Stop() {
  RequestStop();
  if (thread_.joinable()) thread_.join();
}

void TickThread::Run() {
  const base::RealtimeThread named("omni-tick");
  if (options_.realtime) realtime_ = RequestRealtime(options_.priority);
  FlushDenormals();
  started_.store(true, std::memory_order_release);
  started_.notify_all();
  base::HallScan scan;
  WaitStatus status = WaitStatus::kTick;
  while (!stop_.load(std::memory_order_acquire)) {
    status = source_.Wait(scan);
    if (status == WaitStatus::kTick) {
      Once(scan);
    } else if (status == WaitStatus::kTimeout) {
      statistics_->timeouts.fetch_add(1, std::memory_order_relaxed);
    } else {
      break;
    }
  }
  source_.Apply({});
  end_status_.store(status, std::memory_order_release);
  finished_.store(true, std::memory_order_release);
}

void TickThread::TakeScene(const Commands& commands) noexcept {
  const SceneRef& next = scenes_.Read();
  if (next.generation != commands.scene_generation) return;  // not handed over yet: stay at zero force
  memory_->SaveState(build_, state_.haptics);
  scene_ = next.scene != nullptr ? next.scene : &empty_;
  build_ = next.build;
  EnterScene(*scene_, next.generation, state_);
  memory_->RestoreState(build_, state_.haptics);
  statistics_->scene_generation.store(next.generation, std::memory_order_release);
}

void TickThread::WriteSurfaces(std::int64_t t_ns) noexcept {
  if (!surfaces_wanted_.load(std::memory_order_relaxed) || !SnapshotIsDue(t_ns, surfaces_written_ns_)) return;
  surfaces_->WriteWith([this](SurfaceSnapshot& snapshot) { FillSurfaceSnapshot(state_, snapshot); });
  surfaces_written_ns_ = t_ns;
}

void TickThread::WriteRoom(const base::HallScan& scan) noexcept {
  if (base::StampDifference_ns(scan.t_ns, room_written_ns_) < tracker::RoomSample::kEvery_ns) return;
  room_written_ns_ = scan.t_ns;
  room_.WriteWith([&](tracker::RoomSample& sample) {
    sample = {scan, record_.output.tool, ContactGain(record_.output)};
  });
}

std::int64_t TickThread::OwnerSilence_ns(const OwnerLife& owner, std::int64_t now_ns) noexcept {
  if (owner.page == nullptr) return 0;
  if (owner.number != owner_number_) owner_watch_ = {};
  owner_number_ = owner.number;
  owner_watch_.Update(*owner.page, now_ns);
  return owner_watch_.Silence_ns(now_ns);
}

void TickThread::Once(const base::HallScan& scan) noexcept {
  const Commands& commands = commands_.Read();
  statistics_->owner_number.store(commands.owner.number, std::memory_order_release);
  const bool at_zero = state_.gate == 0 && record_.output.currents.current_A == base::CoilCurrents{}.current_A;
  const bool rests = commands.idle && at_zero;
  if (rests && scan.sequence % static_cast<std::uint64_t>(options_.idle_divider) != 0) return;
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  const TickFeeds feeds{.samples = &vibration_->Read(),
                        .keys = &keys_.Read(),
                        .owner_silence_ns = OwnerSilence_ns(commands.owner, begin_ns)};
  Tick(config_, scan, commands, *scene_, state_, record_.output, feeds);
  const std::int64_t end_ns = base::MonotonicNow_ns();
  source_.Apply(record_.output.currents);
  record_.done_ns = base::MonotonicNow_ns();
  const std::int64_t latency_ns = base::StampDifference_ns(record_.done_ns, scan.t_ns);
  record_.late = latency_ns > kLate_ns;
  sink_.Publish(record_.output, scan, {.tick_ns = end_ns - begin_ns, .latency_ns = latency_ns});
  statistics_->tick_time.Add(end_ns - begin_ns);
  statistics_->latency.Add(latency_ns);
  statistics_->ticks.fetch_add(1, std::memory_order_relaxed);
  statistics_->response_ns.store(scan.response_ns, std::memory_order_relaxed);
  statistics_->vehicle.Store(record_.output.haptics.vehicle);
  statistics_->sources.Store(record_.output.sources);
  statistics_->fit.Count(record_.output.tool);
  if (record_.late) statistics_->late.fetch_add(1, std::memory_order_relaxed);
  if (options_.telemetry) {
    record_.scan = scan;
    if (!telemetry_->TryPush(record_)) statistics_->dropped_records.fetch_add(1, std::memory_order_relaxed);
  }
  WriteSurfaces(scan.t_ns);
  WriteRoom(scan);
  if (record_.output.wants_scene) TakeScene(commands);
}

}  // namespace omni::loop
