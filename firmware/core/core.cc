#include "firmware/core/core.h"

#include "firmware/core/link/settings.h"
#include "firmware/wire/messages.h"
#include "firmware/wire/names.h"

namespace omni::firmware {
namespace {

constexpr int kBootMin_steps = 20 * kStepsPerMs;   // sensors have finished their own start-up
constexpr int kBootMax_steps = 250 * kStepsPerMs;  // a chip that has not answered by now is missing
constexpr int kInStateMax = 1'000'000'000;
constexpr std::uint8_t kAllCoils = (1U << wire::kCoils) - 1;
constexpr std::uint64_t kTick_us = std::uint64_t{kStepPeriod_us} * kStepsPerTick;

int LowestBit(std::uint8_t mask) noexcept {
  int bit = 0;
  while (bit < 7 && ((mask >> bit) & 1U) == 0) ++bit;
  return bit;
}

}  // namespace

Core::Core(const Settings& settings, ResetCause cause, std::uint32_t nonce_seed, FaultRecord& record) noexcept
    : built_(AreValid(settings) ? settings : Settings{}),
      settings_(built_),
      settings_are_valid_(AreValid(settings)),
      latch_(record),
      arming_(nonce_seed),
      heat_(settings_) {
  // Known before any test: the self-test runs anyway, and ends in kFault.
  if (cause == ResetCause::kWatchdog) Note(wire::kFaultWatchdog, kWholeBase, 0);
  // Memory is random after power-on; after any other reset the record should be intact.
  const bool lost_record = latch_.record_was_broken() && cause != ResetCause::kPower;
  if (!settings_are_valid_ || lost_record) Note(wire::kFaultInternal, kWholeBase, 0);
}

std::uint32_t Core::faults() const noexcept {
  return state_ == wire::State::kArmed ? latch_.latched() : latch_.latched() | wire::kFaultNotArmed;
}

void Core::Step(const Inputs& inputs, Outputs& outputs) noexcept {
  outputs = Outputs{};
  proof_ = Proof{};
  ReadClock(inputs);
  Observation seen;
  Observe(inputs, seen);
  Watch(seen);
  Advance(inputs, seen);
  DriveCoils(seen, outputs);
  CheckOutputs(outputs);
  fan_ = FanSpeed(seen);
  outputs.fan = fan_;
  outputs.feed_watchdog = proof_.sensors && proof_.currents && proof_.control && clock_advances_ ? 1 : 0;
  tick_.Add(inputs, end_A_, hall_verdict_, outputs);
  if (--steps_to_tick_ == 0) FinishTick(inputs);
}

void Core::ReadClock(const Inputs& inputs) noexcept {
  clock_advances_ = !has_stepped_ || inputs.now_us > now_us_;
  now_us_ = inputs.now_us;
  if (!has_stepped_) tick_us_ = now_us_;
  has_stepped_ = true;
}

void Core::Observe(const Inputs& inputs, Observation& seen) noexcept {
  hall_verdict_ = hall_.Step(settings_, inputs);
  seen.hall = hall_verdict_;
  seen.measured_mask = inputs.current_answers & kAllCoils;
  for (int k = 0; k < wire::kCoils; ++k) {
    seen.current_A[k] = static_cast<float>(inputs.current[k]) * static_cast<float>(wire::kCurrentUnit_A);
    seen.voltage_V[k] = static_cast<float>(inputs.voltage[k]) * static_cast<float>(wire::kSupplyUnit_V);
    const bool is_measured = ((seen.measured_mask >> k) & 1U) != 0;
    samples_[k] = {seen.current_A[k], seen.voltage_V[k],
                   is_measured && drive_.follows() && drive_.direction(k) * seen.current_A[k] > 0};
    end_A_[k] = EndCurrent(seen, k);
  }
  seen.state = state_;
  seen.driver_fault = inputs.driver_fault & kAllCoils;
  seen.supply_V = static_cast<float>(inputs.supply) * static_cast<float>(wire::kSupplyUnit_V);
  seen.board_C = static_cast<float>(inputs.board_temperature) * static_cast<float>(wire::kTemperatureUnit_K);
  seen.fan_rpm = static_cast<float>(inputs.fan_rpm);
  seen.fan = fan_;
  seen.emergency_stop = inputs.emergency_stop != 0;
  seen.clock_advances = clock_advances_;
  seen.drives_test = state_ == wire::State::kSelfTest && self_test_.drives_coils();
  heat_.Step(settings_, samples_);
  // While coils are driven, the watchdog also requires fresh measurements.
  const bool is_armed = state_ == wire::State::kArmed;
  proof_.sensors = !is_armed || seen.hall.silent != 0xFF;
  proof_.currents = !is_armed || seen.measured_mask != 0;
}

// A sleeping bridge applies no voltage known to the model; its coil soon carries no current.
float Core::EndCurrent(const Observation& seen, int coil) const noexcept {
  const float mean_A = seen.current_A[coil];
  if (((seen.measured_mask >> coil) & 1U) == 0 || drive_.is_asleep()) return mean_A;
  const CoilModel model(heat_.resistance_ohm(coil), settings_.coils[coil].inductance_H);
  return model.EndOf(mean_A, drive_.direction(coil) * seen.voltage_V[coil]);
}

void Core::Watch(const Observation& seen) noexcept {
  monitor_.Step(settings_, seen, heat_, drive_);
  for (int i = 0; i < monitor_.count(); ++i) {
    const Finding& finding = monitor_.finding(i);
    Raise(finding.fault, finding.part, finding.value);
  }
  if (gate_.is_alive(now_us_)) return;
  if (state_ == wire::State::kArmed) {
    Raise(wire::kFaultHostSilent, kWholeBase, static_cast<float>(now_us_ - gate_.heard_us()) * 1e-6F);
  }
  gate_.ResetSequence();
}

void Core::Advance(const Inputs&, const Observation& seen) noexcept {
  if (in_state_ < kInStateMax) ++in_state_;
  test_step_ = SelfTest::Step{};
  if (state_ == wire::State::kBoot) AdvanceBoot(seen);
  if (state_ == wire::State::kSelfTest) AdvanceSelfTest();
}

void Core::AdvanceBoot(const Observation& seen) noexcept {
  if (in_state_ < kBootMin_steps) return;
  const std::uint8_t mute = static_cast<std::uint8_t>(~seen.measured_mask & kAllCoils);
  if (seen.hall.silent == 0 && mute == 0) return StartSelfTest();
  if (in_state_ < kBootMax_steps) return;
  if (mute != 0) Raise(wire::kFaultCurrentSensor, static_cast<std::uint8_t>(LowestBit(mute)), 0);
  if (seen.hall.silent != 0) Raise(wire::kFaultHallSensor, static_cast<std::uint8_t>(LowestBit(seen.hall.silent)), 0);
  Raise(wire::kFaultSelfTest, kWholeBase, 0);
}

void Core::StartSelfTest() noexcept {
  self_test_.Start(retest_);
  Enter(wire::State::kSelfTest);
}

void Core::AdvanceSelfTest() noexcept {
  test_step_ = self_test_.Advance(settings_, hall_, hall_verdict_, samples_);
  if (self_test_.drives_coils()) retest_ &= static_cast<std::uint8_t>(~kRetestHall);
  if (test_step_.result == SelfTest::Result::kRefused) {
    if (test_step_.fault != 0) Raise(static_cast<wire::Fault>(test_step_.fault), test_step_.part, test_step_.value);
    Raise(wire::kFaultSelfTest, test_step_.part, test_step_.value);
  } else if (test_step_.result == SelfTest::Result::kPassed) {
    if ((retest_ & kRetestCoils) != 0) heat_.Start(settings_, self_test_.resistance_ohm());
    retest_ = 0;
    drive_.Sleep();  // the test ends with braking
    Enter(latch_.latched() == 0 ? wire::State::kIdle : wire::State::kFault);
  }
}

void Core::DriveCoils(const Observation& seen, Outputs& outputs) noexcept {
  if (state_ == wire::State::kSelfTest && self_test_.drives_coils()) {
    drive_.StepTest(test_step_.voltage_V, test_step_.awake, seen.supply_V, outputs);
  } else {
    Drive::Demand demand;
    for (int k = 0; k < wire::kCoils; ++k) {
      demand.set_point_A[k] = state_ == wire::State::kArmed ? set_point_A_[k] : 0;
      demand.measured_A[k] = seen.current_A[k];
    }
    demand.measured_mask = seen.measured_mask;
    demand.supply_V = seen.supply_V;
    drive_.Step(settings_, heat_, demand, outputs);
  }
  outputs.hall_self_test = state_ == wire::State::kSelfTest && test_step_.test_field ? 1 : 0;
  proof_.control = true;
}

// No output that was computed from a non-finite number or that was never armed.
void Core::CheckOutputs(Outputs& outputs) noexcept {
  const bool is_allowed = output_check_.Allows(outputs);
  bool is_finite = drive_.is_finite() && IsFinite(heat_.body_C());
  for (int k = 0; k < wire::kCoils; ++k) is_finite = is_finite && IsFinite(heat_.temperature_C(k));
  if (is_allowed && is_finite) return;
  if (!is_allowed)
    Say(LogLine(wire::LogLevel::kError).AddText("a bridge was driven while ").AddText(wire::StateName(state_)));
  Raise(wire::kFaultInternal, kWholeBase, 0);
  Enter(wire::State::kFault);  // whatever the stored state
  drive_.Panic();
  if (!is_finite) heat_ = CoilHeat(settings_);
  for (std::int16_t& duty : outputs.duty) duty = 0;
  outputs.awake = kAllCoils;
}

std::uint8_t Core::FanSpeed(const Observation& seen) const noexcept {
  if (!(seen.supply_V >= settings_.supply_min_V)) return 0;
  const float from_C = settings_.temperature_derate_C - kFanFullFrom_C;
  const float share = Clamp((heat_.hottest_C() - from_C) / kFanFullFrom_C, 0, 1);
  return static_cast<std::uint8_t>(static_cast<float>(kFanIdle) + share * (255 - kFanIdle));
}

void Core::FinishTick(const Inputs& inputs) noexcept {
  steps_to_tick_ = kStepsPerTick;
  const std::uint64_t since_us = now_us_ - tick_us_;
  if (clock_advances_ && since_us > kTick_us + kTick_us / 2) {
    missed_ticks_ = static_cast<std::uint16_t>(missed_ticks_ + (since_us - kTick_us / 2) / kTick_us);
  }
  tick_us_ = now_us_;
  wire::Telemetry telemetry;
  const std::uint64_t t_device_us = tick_.FillTelemetry(settings_, inputs, hall_, heat_, telemetry);
  telemetry.state = state_;
  telemetry.faults = faults();
  telemetry.ack_seq = gate_.seq();
  telemetry.ack_host_us = gate_.host_us();
  // It arrived between the previous step and the next one.
  telemetry.ack_rx_device_us = static_cast<std::uint32_t>(gate_.heard_us() + kStepPeriod_us / 2);
  telemetry.rejected = rejected_;
  telemetry.missed_ticks = missed_ticks_;
  if (!outbox_.PushTelemetry(telemetry, t_device_us)) ++missed_ticks_;
}

void Core::Enter(wire::State state) noexcept {
  if (state == state_) return;
  LogLine line(state == wire::State::kFault ? wire::LogLevel::kWarning : wire::LogLevel::kInfo);
  Say(line.AddText(wire::StateName(state_)).AddText(" -> ").AddText(wire::StateName(state)));
  state_ = state;
  output_check_.SetState(state);
  in_state_ = 0;
}

bool Core::Note(wire::Fault fault, std::uint8_t part, float value) noexcept {
  if (!latch_.Raise(fault, part, value, state_, now_us_)) return false;
  wire::FaultEvent event;
  event.fault = fault;
  event.faults = faults();
  event.state = state_;
  event.part = part;
  event.value = IsFinite(value) ? value : 0;
  event.t_us = now_us_;
  outbox_.Push(event);
  return true;
}

void Core::Raise(wire::Fault fault, std::uint8_t part, float value) noexcept {
  if (!Note(fault, part, value)) return;
  const FaultRule& rule = RuleOf(fault);
  retest_ |= rule.retest;
  drive_.Stop(rule.reaction);
  for (float& set_point_A : set_point_A_) set_point_A = 0;
  Enter((fault & wire::kFaultsOfTheHost) != 0 ? wire::State::kIdle : wire::State::kFault);
}

std::size_t Core::NextFrame(std::uint8_t* frame, std::size_t capacity) noexcept {
  return outbox_.PopFrame(now_us_, frame, capacity);
}

}  // namespace omni::firmware
