// What the tick thread reports: the record of each tick (ring), and running statistics.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "service/base/handover.h"
#include "service/loop/histogram.h"
#include "service/loop/tick.h"
#include "service/tracker/room_sample.h"

namespace omni::loop {

struct TickRecord {
  TickOutput output;
  base::HallScan scan;
  std::int64_t done_ns = 0;  // CLOCK_MONOTONIC after the currents were sent
  bool late = false;
};

// About 2 s at 1 kHz. When full, records are dropped and counted; the tick never waits.
using TelemetryRing = base::SpscRing<TickRecord, 2048>;

// A tick is late when its currents were sent more than one period after the Hall sample they answer.
inline constexpr std::int64_t kLate_ns = base::kTickPeriod_ns;

// The newest tick's car. Each value is consistent; two of them may be of adjacent ticks.
struct VehicleStatistics {
  std::atomic<bool> on{false}, sliding{false};
  std::atomic<std::uint32_t> hits{0}, laps{0};
  std::atomic<double> speed_m_s{0}, lap_s{0}, last_lap_s{0}, best_lap_s{0};

  void Store(const haptics::VehicleReport& report) noexcept {
    constexpr auto kRelaxed = std::memory_order_relaxed;
    on.store(report.on, kRelaxed);
    if (!report.on) return;
    sliding.store(report.sliding, kRelaxed);
    hits.store(report.hits, kRelaxed);
    laps.store(report.laps, kRelaxed);
    speed_m_s.store(report.speed_m_s, kRelaxed);
    lap_s.store(report.lap_s, kRelaxed);
    last_lap_s.store(report.last_lap_s, kRelaxed);
    best_lap_s.store(report.best_lap_s, kRelaxed);
  }
};

// The newest tick's sources of inputs, and how often each was switched on.
struct SourceStatistics {
  std::atomic<base::SourceMask> on{0};
  std::array<std::atomic<std::uint32_t>, base::kSourceCount> times{};

  void Store(base::SourceMask now) noexcept {
    const base::SourceMask before = on.load(std::memory_order_relaxed);
    if (now == before) return;
    for (base::SourceMask rose = now & ~before; rose != 0; rose &= rose - 1) {
      times[static_cast<std::size_t>(__builtin_ctzll(rose))].fetch_add(1, std::memory_order_relaxed);
    }
    on.store(now, std::memory_order_relaxed);
  }
};

// Ticks with a magnet near the base: how many had a pose that explains the readings, and how many had none.
struct FitStatistics {
  std::atomic<std::uint64_t> explained{0}, contradicted{0};

  void Count(const base::ToolState& tool) noexcept {
    if (!(tool.field_rms_T >= tracker::kMagnetNear_T)) return;
    const bool contradicted_now = (tool.limits & base::kToolContradicted) != 0;
    (contradicted_now ? contradicted : explained).fetch_add(1, std::memory_order_relaxed);
  }
};

struct TickStatistics {
  Histogram tick_time;  // Tick alone
  Histogram latency;    // Hall sample -> currents sent
  std::atomic<std::uint64_t> ticks{0};
  std::atomic<std::uint64_t> late{0};
  std::atomic<std::uint64_t> timeouts{0};  // the source had no telemetry in time
  std::atomic<std::uint64_t> dropped_records{0};
  std::atomic<std::int64_t> response_ns{0};  // of the newest scan: how late its base applies commands; 0: not known
  std::atomic<std::uint64_t> scene_generation{0};  // acknowledged: the scene that ticks use now
  std::atomic<std::uint64_t> owner_number{0};      // acknowledged: of OwnerLife; earlier pages are read no more
  VehicleStatistics vehicle;
  SourceStatistics sources;
  FitStatistics fit;
};

// How long a tick took: Tick alone; from the Hall sample until its currents were sent.
struct TickTimes {
  std::int64_t tick_ns = 0;
  std::int64_t latency_ns = 0;
};

// Receives every tick on the tick thread: must not block, allocate or call the system.
class TickSink {
 public:
  virtual ~TickSink() = default;
  virtual void Publish(const TickOutput& output, const base::HallScan& scan, const TickTimes& times) noexcept = 0;
};

}  // namespace omni::loop
