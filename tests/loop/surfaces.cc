// Snapshots for drawing: without allocations, seldom, and only while a client reads.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "service/loop/surface_snapshot.h"
#include "service/loop/tick_thread.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_surfaces {

TEST(SurfaceSnapshots, FillingDoesNotAllocate) {
  const auto state = std::make_unique<loop::LoopState>();
  const auto latest = std::make_unique<base::Latest<loop::SurfaceSnapshot>>();
  state->scene_generation = 3;
  state->t_ns = 17;
  state->haptics.regions[2].offset_m = 0.004;
  state->haptics.soft[1].object = 5;
  state->haptics.soft[1].body.slots[0].dent_m = 0.001;
  state->haptics.moved[0] = {.object = 7, .translation_m = {0, 0, 0.1}};
  const loop::AllocProbe probe;
  latest->WriteWith([&](loop::SurfaceSnapshot& snapshot) { loop::FillSurfaceSnapshot(*state, snapshot); });
  EXPECT_EQ(probe.count(), 0U);
  const loop::SurfaceSnapshot& read = latest->Read();
  EXPECT_EQ(read.scene_generation, 3U);
  EXPECT_EQ(read.t_ns, 17);
  EXPECT_EQ(read.regions[2].offset_m, 0.004);
  EXPECT_EQ(read.soft[0].object, haptics::kNoIndex);
  EXPECT_EQ(read.soft[1].object, 5U);
  EXPECT_EQ(read.soft[1].body.slots[0].dent_m, 0.001);
  EXPECT_EQ(read.moved[0].translation_m.z, 0.1);
}

TEST(SurfaceSnapshots, DueEvery8MillisecondsAndWhenTimeGoesBack) {
  EXPECT_FALSE(loop::SnapshotIsDue(7'999'999, 0));
  EXPECT_TRUE(loop::SnapshotIsDue(8'000'000, 0));
  EXPECT_TRUE(loop::SnapshotIsDue(-1, 0));
  EXPECT_TRUE(loop::SnapshotIsDue(std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()));
}

// Scans of a millisecond each, as fast as they are taken, up to a number that the test raises.
class SteppedSource : public loop::TickSource {
 public:
  loop::WaitStatus Wait(base::HallScan& scan) noexcept override {
    if (sequence_ == allowed.load(std::memory_order_acquire)) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      return loop::WaitStatus::kTimeout;
    }
    scan = {};
    scan.sequence = ++sequence_;
    scan.t_ns = static_cast<std::int64_t>(sequence_) * 1'000'000;
    return loop::WaitStatus::kTick;
  }
  void Apply(const base::CoilCurrents& /*currents*/) noexcept override {}

  std::atomic<std::uint64_t> allowed{0};

 private:
  std::uint64_t sequence_ = 0;
};

struct DeafSink : loop::TickSink {
  void Publish(const loop::TickOutput& /*output*/, const base::HallScan& /*scan*/,
               const loop::TickTimes& /*times*/) noexcept override {}
};

TEST(SurfaceSnapshots, WrittenOnlyWhileRequested) {
  SteppedSource source;
  DeafSink sink;
  loop::TickThread loop(loop::MakeTickConfig(config::DefaultDevice()), {.realtime = false, .idle_divider = 1}, source,
                        sink);
  loop.Start();
  const auto run_to = [&](std::uint64_t tick) {
    source.allowed = tick;
    while (loop.statistics().ticks.load() < tick) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // One wait later the tick that was counted has also written what it writes.
    const std::uint64_t waits = loop.statistics().timeouts.load();
    while (loop.statistics().timeouts.load() < waits + 2) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  run_to(50);
  EXPECT_EQ(loop.surfaces().Read().t_ns, 0) << "no request";
  loop.WantSurfaces(true);
  std::int64_t last_ns = 0;
  int written = 0;
  for (std::uint64_t tick = 51; tick <= 90; ++tick) {
    run_to(tick);
    const std::int64_t t_ns = loop.surfaces().Read().t_ns;
    if (t_ns == last_ns) continue;
    if (last_ns != 0) {
      EXPECT_EQ(t_ns - last_ns, loop::kSurfacePeriod_ns);
    }
    last_ns = t_ns;
    ++written;
  }
  EXPECT_EQ(written, 5);
  loop.WantSurfaces(false);
  run_to(150);
  EXPECT_EQ(loop.surfaces().Read().t_ns, last_ns);
}

}  // namespace test_loop_surfaces
}  // namespace omni::test
