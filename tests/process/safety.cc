// Killed, stopped and silent processes: what the coils do, read from the twin's own recording.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "service/tools/common/row_table.h"
#include "tests/support/process/forked.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_safety {

constexpr double kPushing_N = 0.2;

TEST(ProcessSafety, KilledServiceZeroesCoilsWithin50Milliseconds) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  service.Signal(SIGKILL);
  service.Wait();
  const auto truth = service.Truth();
  ASSERT_TRUE(truth.has_value());
  EXPECT_GT(MillisecondsToZero(*truth, killed_ns - 20'000'000, 100), 0) << "it was pushing";
  const double ms = MillisecondsToZero(*truth, killed_ns, kWholeRecording_ms);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(ProcessSafety, ApplicationReconnectsAfterServiceRestart) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  service.Signal(SIGKILL);
  service.Wait();
  EXPECT_TRUE(app.Run(2000, 5, [&] { return !app.connection().connected(); }));
  service.Start();
  EXPECT_TRUE(app.WaitForForce(kPushing_N)) << "the session state was not sent again";
}

// Focuses and sends heartbeats in a process of its own; reports 1 once it is pushed back.
class ForkedApplication : public Forked {
 public:
  explicit ForkedApplication(const ServiceProcess& service)
      : Forked([&](const Report& report) {
          TestApplication app(service);
          report(app.Focus() && app.WaitForForce(kPushing_N) ? 1 : 0);
          app.Run(30'000, 5);
        }) {}
};

TEST(ProcessSafety, KilledApplicationZeroesCoilsWithin50Milliseconds) {
  ServiceProcess service;
  service.Start();
  ForkedApplication app(service);
  ASSERT_EQ(app.reported(), 1);
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  app.Kill();
  SleepMs(500);
  const double ms = StopAndTimeToZero_ms(service, killed_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(ProcessSafety, StoppedApplicationForceFadesAfter250Milliseconds) {
  ServiceProcess service;
  service.Start();
  ForkedApplication app(service);
  ASSERT_EQ(app.reported(), 1);
  const std::int64_t stopped_ns = base::MonotonicNow_ns();
  app.Stop();
  SleepMs(900);
  app.Kill();
  const double ms = StopAndTimeToZero_ms(service, stopped_ns, 850);
  EXPECT_GE(ms, 240) << "it must bear a hitch of the application";
  EXPECT_LE(ms, 450);
}

TEST(ProcessSafety, LosingFocusZeroesCoilsWithin50Milliseconds) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  const std::int64_t lost_ns = base::MonotonicNow_ns();
  ASSERT_TRUE(app.connection().SendSession(protocol::SessionState::kBegun));
  app.Run(500, 5);
  const double ms = StopAndTimeToZero_ms(service, lost_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

struct Feeling {
  std::vector<double> forces_N;  // at each of the application's frames
  bool stalled = false;  // the computer held omnid, the twin or this process: that cuts the force for a time, and shall
};

// What is felt for 1.5 s by an application with frames of `period_ms`.
Feeling FeelFor(TestApplication& app, int period_ms) {
  constexpr std::int64_t kStall_ns = 10'000'000;
  Feeling felt;
  const auto state = app.connection().state();
  std::uint64_t next = state->published();
  std::int64_t last_ns = 0;
  protocol::ToolSample sample;
  protocol::TelemetrySample telemetry;
  for (int i = 0; i < 1500 / period_ms; ++i) {
    const std::int64_t begin_ns = base::MonotonicNow_ns();
    app.Run(period_ms, period_ms);
    felt.stalled |= base::MonotonicNow_ns() - begin_ns > 2'000'000 * period_ms + kStall_ns;
    for (; next < state->published(); ++next) {
      if (!state->ReadAt(next, sample, telemetry)) continue;
      felt.stalled |= last_ns != 0 && sample.t_ns - last_ns > kStall_ns;
      last_ns = sample.t_ns;
    }
    felt.forces_N.push_back(app.Force_N());
  }
  return felt;
}

// Repeated only while the computer stalls, never because of what was felt.
TEST(ProcessSafety, ContactForceIsSteadyFor20HzApplication) {
  for (int run = 0; run < 6; ++run) {
    ServiceProcess service;
    service.Start();
    TestApplication app(service);
    ASSERT_TRUE(app.Focus());
    ASSERT_TRUE(app.WaitForForce(kPushing_N));
    app.Run(500, 5);  // the hand arrives
    const Feeling fast = FeelFor(app, 5);
    const Feeling slow = FeelFor(app, 50);
    if (fast.stalled || slow.stalled) continue;
    const double fast_N = tools::Mean(fast.forces_N);
    EXPECT_GT(tools::Mean(slow.forces_N), 0.75 * fast_N) << "a slow application must not feel a fading contact";
    EXPECT_GT(*std::min_element(slow.forces_N.begin(), slow.forces_N.end()), 0.25 * fast_N);
    return;
  }
  FAIL() << "the computer stalled in each of the runs";
}

TEST(ProcessSafety, LastFocusedApplicationOwnsForceOthersStillGetPoses) {
  ServiceProcess service;
  service.Start();
  TestApplication first(service);
  TestApplication second(service, "some_other_application");  // has no scene
  ASSERT_TRUE(first.Focus());
  ASSERT_TRUE(first.WaitForForce(kPushing_N));
  ASSERT_TRUE(second.Focus());
  EXPECT_TRUE(second.Run(3000, 5, [&] {
    first.connection().SignalAlive();
    return second.Force_N() == 0;
  })) << "the new owner has no scene: nothing is rendered";
  protocol::ToolSample sample;
  ASSERT_TRUE(first.connection().state()->ReadNewest(sample));
  EXPECT_TRUE(sample.flags & protocol::kToolPoseValid);
  ASSERT_TRUE(second.connection().SendSession(protocol::SessionState::kNone));
  EXPECT_TRUE(first.WaitForForce(kPushing_N)) << "the first one still is focused: it gets the force back";
}

TEST(ProcessSafety, SecondServiceIsRefused) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Run(5000, 5, [&] { return app.connection().connected(); }));
  auto second = test::ChildProcess::Start({std::string(OMNI_BINARY_DIR) + "/bin/omnid", "--device", "twin"},
                                          {"OMNI_SOCKET=" + service.socket_path()});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->Wait(), 1);
  EXPECT_TRUE(app.connection().connected());
}

TEST(ProcessSafety, FullDiskDoesNotStopTheService) {
  ServiceProcess service;
  auto started =
      test::ChildProcess::Start({std::string(OMNI_BINARY_DIR) + "/bin/omnid", "--device", "twin", "--twin", "ideal",
                                 "--twin-script", service.hand_path(), "--record", "/dev/full", "--log-level", "off"},
                                {"OMNI_SOCKET=" + service.socket_path()});
  ASSERT_TRUE(started.ok());
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  protocol::ToolSample sample;
  const auto newest_ns = [&] {
    return app.connection().state() != nullptr && app.connection().state()->ReadNewest(sample) ? sample.t_ns : 0;
  };
  app.Run(1000, 5);
  const std::int64_t before_ns = newest_ns();
  app.Run(500, 5);
  EXPECT_GT(newest_ns(), before_ns);
  kill(started->pid(), SIGTERM);
  EXPECT_EQ(started->Wait(), 0);
}

}  // namespace test_process_safety
}  // namespace omni::test
