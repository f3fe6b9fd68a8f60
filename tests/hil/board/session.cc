#include "tests/hil/board/session.h"

#include <cmath>
#include <cstring>

#include "firmware/wire/messages.h"
#include "service/device/commands.h"

namespace omni::hil {
namespace {

using namespace firmware;

constexpr double kStep_s = 1e-6 * kStepPeriod_us;
constexpr double kSupply_V = 12;
constexpr double kFanMax_rpm = 3000;
// A LIS3MDL's own test field, in the middle of what its data sheet allows.
constexpr double kTestField_T[3] = {2e-4, 2e-4, 0.5e-4};

}  // namespace

const Inputs& NominalBase::Step(const Outputs& outputs) {
  ++step_;
  inputs_.now_us = step_ * kStepPeriod_us;
  inputs_.supply = wire::ToCounts<std::uint16_t>(kSupply_V, wire::kSupplyUnit_V);
  inputs_.board_temperature = wire::ToCounts<std::int16_t>(30, wire::kTemperatureUnit_K);
  inputs_.field_answers = 0xFF;
  inputs_.current_answers = 0x7;
  inputs_.field_fresh = 0;
  for (std::size_t i = 0; i < wire::kSensors; ++i) StepHall(i, outputs.hall_self_test != 0);
  for (std::size_t k = 0; k < wire::kCoils; ++k) StepCoil(k, outputs);
  fan_rpm_ += (kFanMax_rpm * outputs.fan / 255 - fan_rpm_) * kStep_s / 0.3;
  inputs_.fan_rpm = wire::ToCounts<std::uint16_t>(fan_rpm_, 1);
  return inputs_;
}

// L dI/dt = u - R I, exactly, for a mean voltage of duty * supply; an awake bridge with duty 0 brakes.
void NominalBase::StepCoil(std::size_t k, const Outputs& outputs) {
  const CoilSettings& coil = settings_.coils[k];
  const double R_ohm = coil.resistance_20C_ohm * (1 + settings_.resistance_per_K * (copper_C_[k] - 20));
  const bool is_awake = ((outputs.awake >> k) & 1U) != 0;
  const double voltage_V = is_awake ? kSupply_V * outputs.duty[k] / wire::kDutyFull : 0;
  const double decay = std::exp(-R_ohm * kStep_s / coil.inductance_H);
  const double settled_A = voltage_V / R_ohm;
  const double before_A = current_A_[k];
  current_A_[k] = is_awake ? settled_A + (before_A - settled_A) * decay : 0;
  const double mean_A = 0.5 * (before_A + current_A_[k]);
  copper_C_[k] += mean_A * mean_A * R_ohm * kStep_s / settings_.copper_J_K;
  inputs_.current[k] = wire::ToCounts<std::int16_t>(mean_A, wire::kCurrentUnit_A);
  inputs_.voltage[k] = wire::ToCounts<std::uint16_t>(std::abs(voltage_V), wire::kSupplyUnit_V);
}

// Each sensor converts once a millisecond, in a step of its own.
void NominalBase::StepHall(std::size_t i, bool test_field) {
  if (step_ % kStepsPerTick != i % kStepsPerTick) {
    inputs_.field_age_us[i] = static_cast<std::uint16_t>(inputs_.field_age_us[i] + kStepPeriod_us);
    return;
  }
  inputs_.field_fresh = static_cast<std::uint8_t>(inputs_.field_fresh | (1U << i));
  inputs_.field_age_us[i] = 20;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double shown = test_field ? kTestField_T[axis] / settings_.field_lsb_T : 0;
    const double noise = static_cast<double>(random_() % 21) - 10;
    inputs_.field[i][axis] = wire::ToCounts<std::int16_t>(200.0 * static_cast<double>(i) - 700 + shown + noise, 1);
  }
}

LockstepFrame Question(wire::MessageType type, std::uint16_t seq) {
  wire::Header header;
  header.type = type;
  header.seq = seq;
  LockstepFrame frame;
  frame.size = static_cast<std::uint16_t>(wire::SealFrame(header, 0, frame.bytes, sizeof frame.bytes).size);
  return frame;
}

const LockstepRequest& Session::Next(const LockstepAnswer& previous) {
  for (const LockstepFrame& frame : previous.frames) Read(frame);
  request_ = LockstepRequest{};
  frames_ = 0;
  request_.inputs = base_.Step(previous.outputs);
  now_us_ = request_.inputs.now_us;
  if (now_us_ < open_until_us_) request_.inputs.emergency_stop = 1;
  if (manner_ != Manner::kIdle && now_us_ >= silent_until_us_) Speak();
  if (manner_ == Manner::kRough) SpeakRoughly();
  return request_;
}

void Session::Read(const LockstepFrame& frame) {
  wire::FrameView view;
  if (frame.size == 0 || wire::OpenFrame(frame.bytes, frame.size, view) != wire::Status::kOk) return;
  wire::Arm arm;
  const wire::State before = telemetry_.state;
  if (wire::Decode(view, telemetry_) == wire::Status::kOk) {
    ++telemetries_;
    if (telemetry_.state == wire::State::kArmed && before != wire::State::kArmed) ++times_armed_;
  }
  if (wire::Decode(view, arm) == wire::Status::kOk && arm.step == wire::ArmStep::kChallenge) challenge_ = arm;
}

// A command every millisecond; as long as the base is not armed, a request every 40 ms.
void Session::Speak() {
  const std::uint64_t step = now_us_ / kStepPeriod_us;
  if (step % kStepsPerTick != 0) return;
  Send(CommandNow());
  if (challenge_.step == wire::ArmStep::kChallenge) {
    challenge_.step = wire::ArmStep::kConfirm;
    Send(challenge_);
  } else if (telemetry_.state != wire::State::kArmed && step % (40 * kStepsPerTick) == 0) {
    Send(wire::Arm{});
  }
}

// Slow and fast, small and large: a triangle for each coil, and a jump every quarter of a second.
wire::Command Session::CommandNow() {
  wire::Command command;
  const bool is_armed = telemetry_.state == wire::State::kArmed;
  command.mode = is_armed ? wire::Mode::kCurrent : wire::Mode::kOff;
  command.time_to_live_ms = device::kCommandTimeToLive_ms;
  command.host_us = now_us_;
  command.echo_device_us = now_us_;
  const double t_s = 1e-6 * static_cast<double>(now_us_);
  for (int k = 0; is_armed && k < wire::kCoils; ++k) {
    const double phase = std::fmod(t_s * (1.7 + k), 1.0);
    const double jump = static_cast<int>(4 * t_s) % 2 == 0 ? 1 : -1;
    command.set_point_A[k] = static_cast<float>(2 * jump + 16 * std::abs(phase - 0.5) - 4);
  }
  return command;
}

template <class Message>
void Session::Send(const Message& message) {
  if (frames_ == kLockstepFrames) return;
  LockstepFrame& frame = request_.frames[frames_++];
  frame.size = static_cast<std::uint16_t>(wire::Encode(message, ++seq_, 0, frame.bytes, sizeof frame.bytes).size);
}

// About one step in twenty is disturbed.
void Session::SpeakRoughly() {
  const std::uint64_t dice = random_();
  LockstepFrame& frame = request_.frames[0];
  switch (dice % 160) {
    case 0:  // a bit flips
      if (frame.size > 0) frame.bytes[(dice >> 16) % frame.size] ^= static_cast<std::uint8_t>(1U << ((dice >> 8) % 8));
      break;
    case 1:
      frame.size = static_cast<std::uint16_t>(frame.size / 2);
      break;
    case 2:  // claims more bytes than there are
      frame.size = static_cast<std::uint16_t>(dice >> 48);
      break;
    case 3:  // comes again, much later
      std::swap(frame, kept_);
      break;
    case 4:
      std::swap(request_.frames[0], request_.frames[1]);
      break;
    case 5:
      frame = Question(wire::MessageType::kHello, ++seq_);
      break;
    case 6: {
      wire::Config config;
      config.id = static_cast<std::uint16_t>((dice >> 16) % 64);
      config.op = (dice >> 32) % 2 == 0 ? wire::ConfigOp::kGet : wire::ConfigOp::kSet;
      config.value = static_cast<float>((dice >> 40) % 20);
      Send(config);
      break;
    }
    case 7:
      frame = Question(wire::MessageType::kFault, ++seq_);
      break;
    default:
      break;
  }
  if ((dice >> 20) % 16000 == 0) silent_until_us_ = now_us_ + 60'000;
  if ((dice >> 36) % 24000 == 0) open_until_us_ = now_us_ + 20'000;
}

}  // namespace omni::hil
