// An application's own force and constraint through the real omnid: at zero in time, read from the twin's own recording
// of its coils.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "tests/support/service_process.h"

namespace omni::test {
namespace {

constexpr double kWholeRecording_ms = 1e6;
constexpr double kPush_N = 0.6;

// A pen held still over the base, nothing to touch.
constexpr const char* kHoldStill = R"({"name": "hold", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}]})";

class ForceProcess : public ServiceProcess {
 public:
  ForceProcess() : ServiceProcess(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kHoldStill) { Start(); }
};

// Has no scene: what is felt is what it asks for.
class ForceApplication : public TestApplication {
 public:
  explicit ForceApplication(const ServiceProcess& service) : TestApplication(service, "force_test") {}

  // Focused, served, and the device has told what it can do.
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
    connection().SendForce(apply);
    last_push_ns_ = apply.t_ns;
  }
  bool Hold() {
    protocol::ForceConstraints set;
    set.t_ns = base::MonotonicNow_ns();
    set.count = 1;
    set.constraints[0].stiffness_N_m = 300;
    set.constraints[0].max_force_N = 1;
    set.constraints[0].point_base_m = {0, 0, 0.065};
    return connection().SendConstraints(set);
  }
  // Renews the force every 10 ms until it is felt, and for half a second more.
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

// Ends the service; milliseconds from t_ns until the coils were at zero for good. It must have pushed until then.
double TimeToZero_ms(ServiceProcess& service, const char* what, std::int64_t t_ns, double horizon_ms) {
  EXPECT_EQ(service.Stop(), 0);
  const auto truth = service.Truth();
  if (!truth.has_value()) return -1;
  EXPECT_GT(MillisecondsToZero(*truth, t_ns - 20'000'000, 20), 0) << what << ": it was pushing before";
  const double ms = MillisecondsToZero(*truth, t_ns, horizon_ms);
  std::printf("[ figure   ] coils at zero %.1f ms after %s\n", ms, what);
  return ms;
}

TEST(ProcessForce, DeadmanEndsTheForce) {
  ForceProcess service;
  ForceApplication app(service);
  ASSERT_TRUE(app.Claim()) << app.connection().last_error();
  ASSERT_TRUE(app.PushUntilFelt());
  app.Push(40'000'000);
  const std::int64_t end_ns = app.last_push_ns() + 40'000'000;
  app.Run(500, 5);  // it lives, but asks for nothing more
  const double ms = TimeToZero_ms(service, "the deadman's end", end_ns, kWholeRecording_ms);
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
  const double ms = TimeToZero_ms(service, "focus loss", lost_ns, kWholeRecording_ms);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

// Forks an application that holds a constraint, or pushes for ever; its pid once that is felt.
pid_t ForkPusher(const ServiceProcess& service, bool pushes) {
  int ready[2];
  if (pipe(ready) != 0) return -1;
  const pid_t pid = fork();
  if (pid == 0) {
    ForceApplication app(service);
    bool felt = app.Claim();
    felt = felt && (pushes ? app.PushUntilFelt() : app.Hold() && app.WaitForForce(0.5));
    const char ok = felt ? 'y' : 'n';
    if (write(ready[1], &ok, 1) != 1) _exit(1);
    app.Run(30'000, 5, [&] {
      if (pushes) app.Push(100'000'000);
      return false;
    });
    _exit(0);
  }
  char answer = 'n';
  close(ready[1]);
  if (read(ready[0], &answer, 1) != 1) answer = 'n';
  close(ready[0]);
  if (answer == 'y') return pid;
  kill(pid, SIGKILL);
  waitpid(pid, nullptr, 0);
  return -1;
}

TEST(ProcessForce, KilledApplicationEndsTheForce) {
  ForceProcess service;
  const pid_t app = ForkPusher(service, true);
  ASSERT_GT(app, 0);
  SleepMs(100);
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  kill(app, SIGKILL);
  waitpid(app, nullptr, 0);
  SleepMs(500);
  const double ms = TimeToZero_ms(service, "kill -9 of an application that pushes", killed_ns, kWholeRecording_ms);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(ProcessForce, KilledApplicationEndsTheConstraint) {
  ForceProcess service;
  const pid_t app = ForkPusher(service, false);
  ASSERT_GT(app, 0);
  SleepMs(100);
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  kill(app, SIGKILL);
  waitpid(app, nullptr, 0);
  SleepMs(500);
  const double ms =
      TimeToZero_ms(service, "kill -9 of an application that holds a constraint", killed_ns, kWholeRecording_ms);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

// Signs of life are looked at every 10 ms; 50 ms without one close, and that takes at most 50 ms more.
TEST(ProcessForce, SilentApplicationEndsTheConstraint) {
  ForceProcess service;
  const pid_t app = ForkPusher(service, false);
  ASSERT_GT(app, 0);
  SleepMs(100);
  const std::int64_t stopped_ns = base::MonotonicNow_ns();
  kill(app, SIGSTOP);
  SleepMs(600);
  kill(app, SIGKILL);
  waitpid(app, nullptr, 0);
  const double ms = TimeToZero_ms(service, "the last sign of life", stopped_ns, 550);
  EXPECT_GE(ms, 40) << "it must bear a hitch of the application";
  EXPECT_LE(ms, 100);
}

TEST(ProcessForce, AMonitorCannotPush) {
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
  EXPECT_FALSE(monitor.SendForce({}));
}

}  // namespace
}  // namespace omni::test
