// An application's own force and constraint through the real omnid: at zero in time, read from the twin's own recording
// of its coils.
#include <gtest/gtest.h>

#include "tests/support/process/forked.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_force {

constexpr double kPush_N = 0.6;

// A pen held still over the base, nothing to touch.
constexpr const char* kHoldStill = R"({"name": "hold", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}]})";

class ForceProcess : public ServiceProcess {
 public:
  ForceProcess() : ServiceProcess(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kHoldStill) { Start(); }
};

// Has no scene: the only force is the one that it requests.
class ForceApplication : public TestApplication {
 public:
  explicit ForceApplication(const ServiceProcess& service) : TestApplication(service, "force_test") {}

  // Focused, owner of the force, and with the device's properties received.
  bool Claim() {
    return Focus() && connection().ClaimForce(true) && Run(8000, 2, [&] {
             return connection().force_standing() == protocol::ForceStanding::kYours &&
                    connection().force_properties().available == 1;
           });
  }
  void Push(std::int64_t duration_ns) {
    protocol::ForceApply apply;
    apply.t_ns = base::MonotonicNow_ns();
    apply.duration_ns = duration_ns;
    apply.force_base_N = {0, 0, kPush_N};
    connection().Send(apply);
    last_push_ns_ = apply.t_ns;
  }
  bool Hold() {
    protocol::ForceConstraints set;
    set.t_ns = base::MonotonicNow_ns();
    set.count = 1;
    set.constraints[0].stiffness_N_m = 300;
    set.constraints[0].max_force_N = 1;
    set.constraints[0].point_base_m = {0, 0, 0.065};
    return connection().Send(set);
  }
  // Renews the force every 10 ms until it is rendered, and for half a second more.
  bool PushUntilFelt() {
    const bool felt = Run(8000, 10, [&] {
      Push(100'000'000);
      return Force_N() > 0.9 * kPush_N;
    });
    const std::int64_t end_ns = base::MonotonicNow_ns() + 500'000'000;
    Run(1000, 10, [&] {
      Push(100'000'000);
      return base::MonotonicNow_ns() > end_ns;
    });
    return felt;
  }
  std::int64_t last_push_ns() const { return last_push_ns_; }

 private:
  std::int64_t last_push_ns_ = 0;
};

TEST(ProcessForce, ExpiredDurationEndsTheForce) {
  ForceProcess service;
  ForceApplication app(service);
  ASSERT_TRUE(app.Claim()) << app.connection().last_error();
  ASSERT_TRUE(app.PushUntilFelt());
  app.Push(40'000'000);
  const std::int64_t end_ns = app.last_push_ns() + 40'000'000;
  app.Run(500, 5);  // alive, but without further requests
  const double ms = StopAndTellTimeToZero_ms(service, "the deadman's end", end_ns);
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
  const double ms = StopAndTellTimeToZero_ms(service, "focus loss", lost_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

// Holds a constraint, or pushes forever, in a process of its own; reports 1 once that is rendered.
class ForkedPusher : public Forked {
 public:
  ForkedPusher(const ServiceProcess& service, bool pushes)
      : Forked([&](const Report& report) {
          ForceApplication app(service);
          const bool felt = app.Claim() && (pushes ? app.PushUntilFelt() : app.Hold() && app.WaitForForce(0.5));
          report(felt ? 1 : 0);
          app.Run(30'000, 5, [&] {
            if (pushes) app.Push(100'000'000);
            return false;
          });
        }) {}
};

void ExpectKillEndsTheForce(bool pushes, const char* what) {
  ForceProcess service;
  ForkedPusher app(service, pushes);
  ASSERT_EQ(app.reported(), 1);
  SleepMs(100);
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  app.Kill();
  SleepMs(500);
  const double ms = StopAndTellTimeToZero_ms(service, what, killed_ns);
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
  const double ms = StopAndTellTimeToZero_ms(service, "the last sign of life", stopped_ns, 550);
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
