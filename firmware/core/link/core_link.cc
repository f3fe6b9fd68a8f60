// Frames from the host. A frame that is invalid, out of order or not allowed now is counted and has no effect.
#include "firmware/core/core.h"
#include "firmware/core/link/settings.h"

namespace omni::firmware {
namespace {

constexpr std::size_t kVersionAt = 2;  // in a frame's header

}  // namespace

void Core::Receive(const std::uint8_t* frame, std::size_t size) noexcept {
  wire::FrameView view;
  if (wire::OpenFrame(frame, size, view) != wire::Status::kOk) return Reject();
  switch (view.header.type) {
    case wire::MessageType::kHello:
      return OnHello(view, frame[kVersionAt]);
    case wire::MessageType::kCommand:
      return OnCommand(view);
    case wire::MessageType::kConfig:
      return OnConfig(view);
    case wire::MessageType::kArm:
      return OnArm(view);
    case wire::MessageType::kEstop:
      return OnEstop(view);
    case wire::MessageType::kFault:
      return OnFaultRequest(view);
    case wire::MessageType::kTelemetry:
    case wire::MessageType::kLog:
      return Reject();  // only the base sends these
  }
  Reject();
}

// Empty: a request for the base's identity. With a payload the host reports its protocol versions. A new host begins
// with it, so any sequence of commands may follow; but not while coils are driven, where a replay could exploit that.
void Core::OnHello(const wire::FrameView& view, std::uint8_t version) noexcept {
  std::uint8_t oldest = version, newest = version;
  if (view.payload_size >= 2) {
    oldest = view.payload[0];
    newest = view.payload[1];
  }
  host_is_compatible_ = oldest <= wire::kVersion && wire::kVersion <= newest;
  if (!host_is_compatible_) {
    LogLine line(wire::LogLevel::kWarning);
    line.AddText("refuses to arm: the host speaks protocol ").AddNumber(oldest).AddText(" to ").AddNumber(newest);
    Say(line.AddText(", this base ").AddNumber(wire::kVersion));
  }
  if (state_ != wire::State::kArmed) {
    gate_.ResetSequence();
    has_config_seq_ = false;
  }
  outbox_.Push(Identity());
}

wire::Hello Core::Identity() const noexcept {
  wire::Hello hello;
  hello.firmware_version = settings_.firmware_version;
  hello.capabilities = settings_.capabilities;
  for (std::size_t i = 0; i < sizeof hello.serial; ++i) hello.serial[i] = settings_.serial[i];
  hello.field_lsb_T = settings_.field_lsb_T;
  hello.field_full_scale = settings_.field_full_scale;
  hello.current_max_A = settings_.current_max_A;
  return hello;
}

// While not armed, a command only shows that the host is present.
void Core::OnCommand(const wire::FrameView& view) noexcept {
  wire::Command command;
  if (wire::DecodeCommand(view, settings_.current_max_A, command) != wire::Status::kOk) return Reject();
  if (!gate_.Accept(command, view.header.seq, now_us_)) return Reject();
  const bool acts = state_ == wire::State::kArmed && command.mode == wire::Mode::kCurrent;
  for (int k = 0; k < wire::kCoils; ++k) set_point_A_[k] = acts ? command.set_point_A[k] : 0;
}

void Core::OnConfig(const wire::FrameView& view) noexcept {
  wire::Config config;
  if (wire::Decode(view, config) != wire::Status::kOk) return Reject();
  if (config.op != wire::ConfigOp::kGet && config.op != wire::ConfigOp::kSet) return Reject();
  wire::Config answer = config;
  answer.op = wire::ConfigOp::kValue;
  if (config.op == wire::ConfigOp::kSet) {
    const bool is_replay = has_config_seq_ && wire::SeqDistance(config_seq_, view.header.seq) <= 0;
    if (is_replay) return Reject();
    has_config_seq_ = true;
    config_seq_ = view.header.seq;
    const bool may_set = state_ == wire::State::kIdle && drive_.is_asleep();
    if (!may_set || SetConfig(built_, config.id, config.value, settings_) != ConfigStatus::kOk) {
      answer.op = wire::ConfigOp::kRefused;
      Reject();
    }
  }
  answer.value = 0;
  if (GetConfig(settings_, config.id, answer.value) != ConfigStatus::kOk) answer.op = wire::ConfigOp::kRefused;
  outbox_.Push(answer);
}

void Core::OnArm(const wire::FrameView& view) noexcept {
  wire::Arm asked;
  if (wire::Decode(view, asked) != wire::Status::kOk) return Reject();
  if (asked.step != wire::ArmStep::kRequest && asked.step != wire::ArmStep::kConfirm) return Reject();
  outbox_.Push(AnswerArm(asked));
}

wire::Arm Core::RefuseArm(std::uint32_t faults) noexcept {
  wire::Arm answer;
  answer.step = wire::ArmStep::kRefused;
  answer.faults = faults;
  return answer;
}

wire::Arm Core::AnswerArm(const wire::Arm& asked) noexcept {
  wire::Arm answer;
  answer.step = wire::ArmStep::kArmed;
  if (state_ == wire::State::kArmed) return answer;
  if (asked.version != wire::kVersion || !host_is_compatible_) return RefuseArm(faults());
  const bool confirms = asked.step == wire::ArmStep::kConfirm;
  if (confirms && !arming_.Confirm(asked.nonce, now_us_)) {
    Reject();
    return RefuseArm(faults());
  }
  if (const std::uint32_t obstacles = ArmObstacles(); obstacles != 0) return RefuseArm(obstacles);
  if (!confirms) {
    answer.step = wire::ArmStep::kChallenge;
    answer.nonce = arming_.Challenge(now_us_);
    return answer;
  }
  latch_.Clear(latch_.latched());
  for (float& set_point_A : set_point_A_) set_point_A = 0;
  gate_.StartWaiting(now_us_);
  drive_.Wake();
  Enter(wire::State::kArmed);
  return answer;
}

// Reasons for refusal: causes of latched faults that are still present, bridges that are not yet at rest, a self-test
// that has not ended. A fault that invalidates the self-test starts it; request again when it has ended.
std::uint32_t Core::ArmObstacles() noexcept {
  std::uint32_t obstacles = monitor_.causes() & latch_.latched();
  if (!settings_are_valid_) obstacles |= wire::kFaultInternal;
  const bool was_silent = (latch_.latched() & wire::kFaultHostSilent) != 0;
  if (was_silent && !gate_.is_alive(now_us_)) obstacles |= wire::kFaultHostSilent;
  if (obstacles != 0) return obstacles;
  if (state_ == wire::State::kBoot || state_ == wire::State::kSelfTest) return wire::kFaultSelfTest;
  if (!drive_.is_asleep()) return faults();
  if (retest_ == 0) return 0;
  latch_.Clear(latch_.latched());
  StartSelfTest();
  return wire::kFaultSelfTest;
}

void Core::OnEstop(const wire::FrameView& view) noexcept {
  wire::Estop estop;
  if (wire::Decode(view, estop) != wire::Status::kOk) return Reject();
  Raise(wire::kFaultEmergencyStop, kWholeBase, static_cast<float>(estop.reason));
}

void Core::OnFaultRequest(const wire::FrameView& view) noexcept {
  if (view.payload_size != 0) return Reject();
  outbox_.Push(latch_.BeforeReset());
}

void Core::Say(const LogLine& line) noexcept {
  if (log_rate_.Allows(now_us_)) outbox_.Push(line.log());
}

}  // namespace omni::firmware
