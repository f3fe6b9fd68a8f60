// An application's own force and constraint through the real omnid: at zero in time, read from the twin's own recording
// of its coils.
#include <gtest/gtest.h>

#include "tests/support/process/force_process.h"

namespace omni::test {
namespace test_process_force {

TEST(ProcessForce, ExpiredDurationEndsTheForce) {
  ForceProcess service;
  ForceApplication app(service);
  ASSERT_TRUE(app.Claim()) << app.connection().last_error();
  ASSERT_TRUE(app.PushUntilFelt());
  app.Push(40'000'000);
  const std::int64_t end_ns = app.last_push_ns() + 40'000'000;
  app.Run(500, 5);  // alive, but without further requests
  const double ms = StopAndPrintTimeToZero_ms(service, "the deadman's end", end_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(ProcessForce, LosingFocusEndsForceAndConstraint) {
  ForceProcess service;
  ForceApplication app(service);
  ASSERT_TRUE(app.Claim());
  ASSERT_TRUE(app.Hold());
  ASSERT_TRUE(app.PushUntilFelt());
  const std::int64_t lost_ns = base::MonotonicNow_ns();
  ASSERT_TRUE(app.connection().SendSession(protocol::SessionState::kBegun));
  app.Run(500, 5);
  const double ms = StopAndPrintTimeToZero_ms(service, "focus loss", lost_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

void ExpectKillEndsTheForce(bool pushes, const char* what) {
  ForceProcess service;
  ForkedPusher app(service, pushes);
  ASSERT_EQ(app.reported(), 1);
  SleepMs(100);
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  app.Kill();
  SleepMs(500);
  const double ms = StopAndPrintTimeToZero_ms(service, what, killed_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(ProcessForce, KilledApplicationEndsTheForce) {
  ExpectKillEndsTheForce(true, "kill -9 of an application that pushes");
}

TEST(ProcessForce, KilledApplicationEndsTheConstraint) {
  ExpectKillEndsTheForce(false, "kill -9 of an application that holds a constraint");
}

// Heartbeats are checked every 10 ms; 50 ms without one closes the gate, which takes at most 50 ms more.
TEST(ProcessForce, SilentApplicationEndsTheConstraint) {
  ForceProcess service;
  ForkedPusher app(service, false);
  ASSERT_EQ(app.reported(), 1);
  SleepMs(100);
  const std::int64_t stopped_ns = base::MonotonicNow_ns();
  app.Stop();
  SleepMs(600);
  app.Kill();
  const double ms = StopAndPrintTimeToZero_ms(service, "the last sign of life", stopped_ns, 550);
  EXPECT_GE(ms, 40) << "it must bear a hitch of the application";
  EXPECT_LE(ms, 100);
}

TEST(ProcessForce, MonitorCannotApplyForce) {
  ForceProcess service;
  client::Connection monitor({.role = protocol::ClientRole::kMonitor,
                              .application = "monitor",
                              .socket_path = service.socket_path(),
                              .retry_interval_ns = 50'000'000});
  for (int i = 0; i < 1000 && !monitor.connected(); ++i) {
    monitor.Poll(base::MonotonicNow_ns());
    SleepMs(5);
  }
  ASSERT_TRUE(monitor.connected());
  EXPECT_FALSE(monitor.ClaimForce(true));
  EXPECT_FALSE(monitor.Send(protocol::ForceApply{}));
}

}  // namespace test_process_force
}  // namespace omni::test
