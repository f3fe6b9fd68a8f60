// When a calibration is reported as a misfit: magnet near, but no pose that fits, for some seconds.
#include "service/room/fit_watch.h"

#include <gtest/gtest.h>

namespace omni::room {
namespace test_room_fit_watch {

// Ten polls a second of a loop with so many ticks a second.
struct Scenario {
  FitWatch watch;
  std::uint64_t explained = 0, contradicted = 0;
  std::int64_t now_ns = 1'000'000'000;
  int changes = 0;

  void Run(double seconds, int explained_per_poll, int contradicted_per_poll) {
    for (int i = 0; i < 10 * seconds; ++i) {
      explained += static_cast<std::uint64_t>(explained_per_poll);
      contradicted += static_cast<std::uint64_t>(contradicted_per_poll);
      now_ns += 100'000'000;
      changes += watch.Update(explained, contradicted, now_ns) ? 1 : 0;
    }
  }
};

TEST(RoomFitWatch, MisfitAfterSecondsWithoutAPoseUntilPosesReturn) {
  Scenario scenario;
  scenario.Run(2.5, 0, 100);
  EXPECT_FALSE(scenario.watch.misfit()) << "too early";
  scenario.Run(0.9, 0, 100);
  EXPECT_TRUE(scenario.watch.misfit());
  EXPECT_EQ(scenario.watch.share(), 1);
  scenario.Run(60, 0, 0);
  EXPECT_TRUE(scenario.watch.misfit()) << "a pen that is away does not count";
  scenario.Run(7, 100, 0);
  EXPECT_FALSE(scenario.watch.misfit());
  EXPECT_EQ(scenario.changes, 2) << "each reported once";
}

TEST(RoomFitWatch, NoMisfitWhileThePenIsAwayOrTracked) {
  Scenario scenario;
  scenario.Run(60, 0, 0);
  scenario.Run(60, 100, 1);
  scenario.Run(0.9, 0, 100);  // a second magnet passes
  scenario.Run(60, 100, 1);
  EXPECT_EQ(scenario.changes, 0);
}

TEST(RoomFitWatch, PartialTrackingIsAMisfitWithoutFlicker) {
  Scenario scenario;
  scenario.Run(30, 80, 20);
  EXPECT_TRUE(scenario.watch.misfit());
  EXPECT_NEAR(scenario.watch.share(), 0.2, 0.02);
  scenario.Run(30, 92, 8);
  EXPECT_TRUE(scenario.watch.misfit());
  EXPECT_EQ(scenario.changes, 1);
}

TEST(RoomFitWatch, DetectsMisfitInAnIdleLoop) {
  Scenario scenario;
  scenario.Run(8, 0, 6);
  EXPECT_TRUE(scenario.watch.misfit());
}

}  // namespace test_room_fit_watch
}  // namespace omni::room
