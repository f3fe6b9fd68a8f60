// The control core with its plant and a host at 1 kHz: scenarios in milliseconds of virtual time.
#pragma once

#include <functional>
#include <new>
#include <string>
#include <vector>

#include "firmware/core/core.h"
#include "service/device/commands.h"
#include "tests/support/chips/firmware_plant.h"

namespace omni::firmware {

using Bytes = std::vector<std::uint8_t>;

class FirmwareBench {
 public:
  explicit FirmwareBench(const Settings& settings = {}, const FirmwarePlant::Options& options = {},
                         ResetCause cause = ResetCause::kPower, const FaultRecord& record_before = {})
      : record(record_before),
        core(settings, cause, kNonceSeed, record),
        plant(settings, options),
        settings_(settings) {}

  // One control step, and the frames that follow it.
  void Step() {
    ++steps_;
    if (start_steps_ > 0) {
      StepReset();
    } else {
      core.Step(plant.Step(outputs), outputs);
      Fetch();
    }
    if (host_speaks && start_steps_ == 0 && steps_ % kStepsPerTick == 0) SendCommand();
    if (each_step) each_step();
  }
  void RunMs(double milliseconds) {
    const auto steps = static_cast<std::int64_t>(milliseconds * 4);
    for (std::int64_t i = 0; i < steps; ++i) Step();
  }
  // False: it never arrived.
  bool RunUntil(wire::State state, double milliseconds) {
    for (double left = milliseconds * 4; left > 0 && core.state() != state; --left) Step();
    return core.state() == state;
  }

  void Fetch() {
    std::uint8_t frame[wire::kFrameSizeMax];
    for (std::size_t size = core.NextFrame(frame, sizeof frame); size > 0; size = core.NextFrame(frame, sizeof frame)) {
      wire::FrameView view;
      if (wire::OpenFrame(frame, size, view) != wire::Status::kOk) ++bad_frames;
      if (view.header.type == wire::MessageType::kTelemetry) {
        wire::Decode(view, telemetry);
        telemetry_us = view.header.t_device_us;
        ++telemetry_count;
      } else {
        answers.emplace_back(frame, frame + size);
      }
    }
  }

  template <class Message>
  Bytes Encoded(const Message& message) {
    Bytes frame(wire::kFrameSizeMax);
    frame.resize(wire::Encode(message, ++seq, 0, frame.data(), frame.size()).size);
    return frame;
  }
  void Receive(const Bytes& frame) { core.Receive(frame.data(), frame.size()); }
  template <class Message>
  void Send(const Message& message) {
    Receive(Encoded(message));
  }

  wire::Command CommandNow() {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    command.host_us = steps_ * kStepPeriod_us;
    command.time_to_live_ms = time_to_live_ms;
    for (int k = 0; k < wire::kCoils; ++k) command.set_point_A[k] = set_point_A[k];
    return command;
  }
  void SendCommand() { Send(CommandNow()); }
  void SetAll(float current_A) {
    for (float& set_point : set_point_A) set_point = current_A;
  }

  // The newest response of a type that has not been read yet; false: none.
  template <class Message>
  bool Take(Message& message) {
    for (auto frame = answers.rbegin(); frame != answers.rend(); ++frame) {
      wire::FrameView view;
      if (wire::OpenFrame(frame->data(), frame->size(), view) != wire::Status::kOk) continue;
      if (wire::Decode(view, message) != wire::Status::kOk) continue;
      answers.erase(std::next(frame).base());
      return true;
    }
    return false;
  }

  // Both steps. Returns the response to the last one sent.
  wire::Arm Arm() {
    wire::Arm asked;
    Send(asked);
    Fetch();
    wire::Arm answer;
    answer.step = wire::ArmStep::kRequest;
    Take(answer);
    if (answer.step != wire::ArmStep::kChallenge) return answer;
    asked.step = wire::ArmStep::kConfirm;
    asked.nonce = answer.nonce;
    Send(asked);
    Fetch();
    Take(answer);
    return answer;
  }
  // The micro-controller computes nothing for `hang_ms`, its pins as they are, and starts again. Meanwhile the board's
  // pull-downs brake (firmware/README.md, pins PWM and SLP). Plant, host and record stay.
  void Reset(ResetCause cause, double hang_ms = 0) {
    reset_cause_ = cause;
    hang_steps_ = static_cast<int>(hang_ms * kStepsPerMs);
    start_steps_ = kStart_steps;
  }
  // Boot, self-test, two steps.
  bool RunToArmed() { return RunUntil(wire::State::kIdle, 1000) && Arm().step == wire::ArmStep::kArmed; }

  FaultRecord record;
  Core core;
  FirmwarePlant plant;
  Outputs outputs;
  bool host_speaks = true;
  std::uint16_t time_to_live_ms = device::kCommandTimeToLive_ms;
  float set_point_A[wire::kCoils] = {};
  std::uint16_t seq = 0;
  std::function<void()> each_step;

  wire::Telemetry telemetry;
  std::uint64_t telemetry_us = 0;
  int telemetry_count = 0;
  int bad_frames = 0;
  std::vector<Bytes> answers;

 private:
  static constexpr std::uint32_t kNonceSeed = 12345;
  static constexpr int kStart_steps = 10 * kStepsPerMs;  // at least; SLP stays up for that long

  void StepReset() {
    if (hang_steps_ > 0) {
      --hang_steps_;
    } else {
      outputs = Outputs{};
      outputs.awake = (1U << wire::kCoils) - 1;
      --start_steps_;
    }
    plant.Step(outputs);
    if (start_steps_ > 0) return;
    core.~Core();
    new (&core) Core(settings_, reset_cause_, ++nonce_seed_, record);
  }

  Settings settings_;
  std::uint32_t nonce_seed_ = kNonceSeed;
  ResetCause reset_cause_ = ResetCause::kPower;
  int hang_steps_ = 0, start_steps_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace omni::firmware
