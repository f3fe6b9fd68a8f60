// Events while a hand presses against a surface: faults at given times, and how fast the coils react.
// All times are device times.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/sim/coils/plant.h"
#include "tests/hil/chain.h"
#include "tests/hil/time/host_process.h"
#include "tests/hil/usb/usb_emulator.h"

namespace omni::hil {

// Everything an event may change.
struct Rig {
  sim::Plant& plant;
  UsbEmulator& usb;
  HostProcess& host;
  Chain& chain;
};

struct Event {
  double at_s = 0;  // after the pen has been in contact for a while
  const char* what = nullptr;
  base::Status (*act)(Rig&) = nullptr;
  bool takes_force = true;  // then it waits until a coil has more than kContact_A, and later events with it
};

constexpr std::size_t kEventsMax = 4;

struct Scenario {
  const char* name;
  const char* about;
  std::array<Event, kEventsMax> events;  // in order; one without an act ends the list
  double end_s;
};

// Null: there is none. AllScenarios: for help and for tests.
const Scenario* FindScenario(const std::string& name);
const std::vector<Scenario>& AllScenarios();

// The reaction to an event, until the next one or the end. Milliseconds of device time after it.
struct Reaction {
  std::string what;
  double t_s = 0;                  // device time
  double window_ms = 0;            // observed
  double peak_A = 0;               // of any coil, at the event or after it
  double hot_A = 0;                // root mean square, while a coil was truly hotter than kHot_C; the worst coil's
  double hottest_C = 0;            // true, of any coil
  double zero_ms = 0;              // last instant with more than kZero_A in any coil
  std::optional<double> fault_ms;  // first telemetry with a fault that was not there at the event
  std::optional<double> back_ms;   // first instant with more than kContact_A again, after they had been at zero
  std::uint32_t faults_seen = 0;   // new ones, at any time of the window
  std::uint32_t faults = 0;        // at its end
  std::uint8_t state = 0;          // wire::State, as above
};

class ScenarioRun {
 public:
  static constexpr double kContact_A = 0.3;  // the pen is pressing
  static constexpr double kContactHeld_s = 0.3;
  static constexpr double kZero_A = 0.02;
  static constexpr double kHot_C = 75;
  static constexpr double kStep_s = 250e-6;

  // `scenario` null: nothing happens, nothing ends.
  ScenarioRun(const Scenario* scenario, double contact_timeout_s)
      : scenario_(scenario), contact_timeout_s_(contact_timeout_s) {}

  // After every control step. An error: an event could not be carried out, or there was no contact in time.
  base::Status Step(Rig& rig);

  bool ended() const { return ended_; }
  double contact_s() const { return static_cast<double>(contact_steps_) * kStep_s; }  // of more than kContact_A
  double peak_A() const { return peak_A_; }
  const std::vector<Reaction>& reactions() const { return reactions_; }

 private:
  void Watch(Rig& rig, double t_s);
  void WatchHeat(const sim::Plant& plant, Reaction& reaction);
  base::Status Advance(Rig& rig, double t_s);

  const Scenario* scenario_;
  double contact_timeout_s_;
  std::optional<double> start_s_;  // of the events' clock
  double now_A_ = 0;               // largest of any coil
  double waited_s_ = 0;            // for a current to take away
  double held_since_s_ = -1;
  std::size_t next_ = 0;
  bool ended_ = false;
  std::uint64_t contact_steps_ = 0;
  double peak_A_ = 0;
  bool at_zero_ = false;
  std::uint32_t faults_before_ = 0;
  std::array<double, 3> hot_square_A2s_{};
  std::array<double, 3> hot_s_{};
  std::vector<Reaction> reactions_;
};

}  // namespace omni::hil
