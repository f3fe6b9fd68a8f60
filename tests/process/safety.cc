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

TEST(ProcessSafety, ContactForceIsSteadyFor20HzApplication) {
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.WaitForForce(kPushing_N));
  app.Run(500, 5);  // the hand arrives
  const auto felt_N = [&](int period_ms) {
    std::vector<double> forces_N;
    for (int i = 0; i < 1500 / period_ms; ++i) {
      app.Run(period_ms, period_ms);
      forces_N.push_back(app.Force_N());
    }
    return forces_N;
  };
  const std::vector<double> fast_N = felt_N(5);
  const std::vector<double> slow_N = felt_N(50);
  EXPECT_GT(tools::Mean(slow_N), 0.75 * tools::Mean(fast_N)) << "a slow application must not feel a fading contact";
  EXPECT_GT(*std::min_element(slow_N.begin(), slow_N.end()), 0.25 * tools::Mean(fast_N));
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
