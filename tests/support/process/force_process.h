// omnid with a pen that is held still over the base, and applications that push it.
#pragma once

#include <cstdint>

#include "tests/support/process/forked.h"
#include "tests/support/process/service_process.h"

namespace omni::test {

inline constexpr double kPush_N = 0.6;

// A pen held still over the base, nothing to touch.
inline constexpr const char* kHoldStill = R"({"name": "hold", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}]})";

class ForceProcess : public ServiceProcess {
 public:
  ForceProcess() : ForceProcess({"--log-level", "warn"}) {}
  explicit ForceProcess(const std::vector<std::string>& options)
      : ServiceProcess(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kHoldStill) {
    Start(options, {});
  }
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

}  // namespace omni::test
