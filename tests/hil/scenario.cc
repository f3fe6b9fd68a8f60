#include "tests/hil/scenario.h"

#include <algorithm>
#include <cmath>
#include <csignal>

namespace omni::hil {
namespace {

constexpr std::size_t kStuckSensor = 2;
constexpr double kContactLost_s = 2;

base::Status PullCable(Rig& rig) {
  rig.usb.Unplug();
  return base::Ok{};
}
base::Status PlugIn(Rig& rig) { return rig.usb.Plug(); }

base::Status DamageSome(Rig& rig) {
  constexpr LinkFaults kSome{.drop = 0.02, .corrupt = 0.1, .truncate = 0.02, .duplicate = 0.02, .reorder = 0.02};
  rig.usb.SetFaults(kSome, kSome);
  return base::Ok{};
}
base::Status DamageAll(Rig& rig) {
  rig.usb.SetFaults({}, {.corrupt = 1});
  return base::Ok{};
}
base::Status DamageNothing(Rig& rig) {
  rig.usb.SetFaults({}, {});
  return base::Ok{};
}

template <int kSignal>
base::Status SignalHost(Rig& rig) {
  rig.host.Signal(kSignal);
  return base::Ok{};
}

base::Status HeatCoils(Rig& rig) {
  rig.plant.faults().extra_heat_W = {400, 400, 400};
  return base::Ok{};
}
base::Status OpenSwitch(Rig& rig) {
  rig.plant.faults().emergency_stop = true;
  return base::Ok{};
}
base::Status CloseSwitch(Rig& rig) {
  rig.plant.faults().emergency_stop = false;
  return base::Ok{};
}
base::Status StickSensor(Rig& rig) {
  rig.plant.faults().hall[kStuckSensor] = sim::HallFault::kStuck;
  return base::Ok{};
}
base::Status FailBridge(Rig& rig) {
  rig.plant.faults().bridge[2] = true;
  return base::Ok{};
}

}  // namespace

const std::vector<Scenario>& AllScenarios() {
  static const std::vector<Scenario> kScenarios = {
      {"steady", "nothing goes wrong", {}, 3.0},
      {"replug",
       "the cable is pulled and comes back",
       {{{0.3, "unplug", &PullCable}, {0.8, "plug in", &PlugIn, false}}},
       4.0},
      {"crc",
       "damaged frames: some, then all commands, then none",
       {{{0.3, "some frames damaged", &DamageSome},
         {1.3, "every command damaged", &DamageAll},
         {1.6, "frames undamaged", &DamageNothing, false}}},
       3.0},
      {"silence",
       "the service is stopped and continues",
       {{{0.3, "service stopped", &SignalHost<SIGSTOP>}, {0.8, "service continued", &SignalHost<SIGCONT>, false}}},
       3.0},
      {"kill", "the service is killed", {{{0.3, "service killed", &SignalHost<SIGKILL>}}}, 0.8},
      {"heat", "an external source heats the coils", {{{0.3, "heating", &HeatCoils}}}, 7.0},
      {"estop",
       "the emergency switch opens and closes",
       {{{0.3, "switch opened", &OpenSwitch}, {0.8, "switch closed", &CloseSwitch, false}}},
       1.8},
      {"stuck", "a Hall sensor repeats its sample", {{{0.3, "sensor stuck", &StickSensor}}}, 1.3},
      {"bridge", "an H bridge fails", {{{0.3, "bridge failed", &FailBridge}}}, 0.8},
  };
  return kScenarios;
}

const Scenario* FindScenario(const std::string& name) {
  for (const Scenario& scenario : AllScenarios()) {
    if (name == scenario.name) return &scenario;
  }
  return nullptr;
}

base::Status ScenarioRun::Step(Rig& rig) {
  const double t_s = static_cast<double>(rig.plant.now_ns()) * 1e-9;
  Watch(rig, t_s);
  if (scenario_ == nullptr || ended_) return base::Ok{};
  return Advance(rig, t_s);
}

void ScenarioRun::Watch(Rig& rig, double t_s) {
  double now_A = 0;
  for (const double current_A : rig.plant.current_A()) now_A = std::max(now_A, std::abs(current_A));
  now_A_ = now_A;
  peak_A_ = std::max(peak_A_, now_A);
  if (now_A > kContact_A) ++contact_steps_;
  if (!(now_A > kContact_A)) held_since_s_ = -1;
  if (now_A > kContact_A && held_since_s_ < 0) held_since_s_ = t_s;
  if (reactions_.empty()) return;
  Reaction& reaction = reactions_.back();
  const wire::Telemetry& telemetry = rig.chain.telemetry();
  reaction.window_ms = 1e3 * (t_s - reaction.t_s);
  reaction.peak_A = std::max(reaction.peak_A, now_A);
  WatchHeat(rig.plant, reaction);
  reaction.faults = telemetry.faults;
  reaction.faults_seen |= telemetry.faults & ~faults_before_;
  reaction.state = static_cast<std::uint8_t>(telemetry.state);
  if (!reaction.fault_ms && (telemetry.faults & ~faults_before_) != 0) reaction.fault_ms = reaction.window_ms;
  if (at_zero_ && !reaction.back_ms && now_A > kContact_A) reaction.back_ms = reaction.window_ms;
  // The reaction to this event: currents after the base is active again do not count as decaying.
  if (now_A > kZero_A && !reaction.back_ms) reaction.zero_ms = reaction.window_ms;
  at_zero_ = now_A <= kZero_A || (at_zero_ && now_A <= kContact_A);
}

// Heating follows the mean square.
void ScenarioRun::WatchHeat(const sim::Plant& plant, Reaction& reaction) {
  reaction.hot_A = 0;
  for (std::size_t k = 0; k < hot_s_.size(); ++k) {
    const double coil_C = plant.temperature_C()[k];
    reaction.hottest_C = std::max(reaction.hottest_C, coil_C);
    if (coil_C > kHot_C) {
      hot_square_A2s_[k] += plant.current_A()[k] * plant.current_A()[k] * kStep_s;
      hot_s_[k] += kStep_s;
    }
    if (hot_s_[k] > 0) reaction.hot_A = std::max(reaction.hot_A, std::sqrt(hot_square_A2s_[k] / hot_s_[k]));
  }
}

base::Status ScenarioRun::Advance(Rig& rig, double t_s) {
  if (!start_s_) {
    if (held_since_s_ >= 0 && t_s - held_since_s_ >= kContactHeld_s) start_s_ = t_s;
    if (!start_s_ && t_s > contact_timeout_s_) {
      return base::Error{std::string("scenario ") + scenario_->name + ": no contact within " +
                         std::to_string(contact_timeout_s_) + " s: is an application attached, and the base armed?"};
    }
    return base::Ok{};
  }
  const double since_s = t_s - *start_s_;
  while (next_ < kEventsMax && scenario_->events[next_].act != nullptr && since_s >= scenario_->events[next_].at_s) {
    const Event& event = scenario_->events[next_];
    if (event.takes_force && !(now_A_ > kContact_A)) {
      *start_s_ += kStep_s;
      waited_s_ += kStep_s;
      if (waited_s_ < kContactLost_s) return base::Ok{};
      return base::Error{std::string(event.what) + ": no coil carries the current that this event waits for"};
    }
    ++next_;
    faults_before_ = rig.chain.telemetry().faults;
    Reaction reaction;
    reaction.what = event.what;
    reaction.t_s = t_s;
    reaction.peak_A = now_A_;
    reactions_.push_back(std::move(reaction));
    hot_square_A2s_ = {};
    hot_s_ = {};
    const base::Status done = event.act(rig);
    if (!done) return base::Error{std::string(event.what) + ": " + done.error()};
  }
  ended_ = since_s >= scenario_->end_s;
  return base::Ok{};
}

}  // namespace omni::hil
