// A host connected to a chain directly, without USB: requests, arms in two steps, commands; for tests of the chain.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/device/commands.h"
#include "tests/hil/chain.h"

namespace omni::hil {

class FakeHost {
 public:
  explicit FakeHost(Chain& chain) : chain_(chain) {}

  // Steps the chain through `ticks` device ticks. With a set-point: a command each tick.
  void Run(int ticks, const std::optional<std::array<float, 3>>& set_point_A = {}) {
    for (int i = 0; i < ticks; ++i) {
      if (set_point_A) Command(*set_point_A);
      for (int step = 0; step < firmware::kStepsPerTick; ++step) {
        const base::Status stepped = chain_.Step();
        ASSERT_TRUE(stepped.ok()) << stepped.error();
      }
      Listen();
    }
  }

  // Until the base is in `state`; false: it is not within `ticks`.
  bool WaitFor(wire::State state, int ticks) {
    for (int i = 0; i < ticks && chain_.telemetry().state != state; ++i) Run(1);
    return chain_.telemetry().state == state;
  }

  // In two steps, repeated until the bridges rest and a pending self-test has ended; at most two seconds.
  bool Arm() {
    for (int attempt = 0; attempt < 200 && chain_.telemetry().state != wire::State::kArmed; ++attempt) {
      nonce_.reset();
      Send(wire::Command{});
      Send(wire::Arm{});
      Run(9);
      if (!nonce_) continue;
      wire::Arm confirm;
      confirm.step = wire::ArmStep::kConfirm;
      confirm.nonce = *nonce_;
      Send(confirm);
      Run(1, std::array<float, 3>{});
    }
    return chain_.telemetry().state == wire::State::kArmed;
  }

  template <class Message>
  void Send(const Message& message) {
    std::uint8_t frame[wire::kFrameSizeMax];
    const wire::Encoded encoded = wire::Encode(message, ++seq_, 0, frame, sizeof frame);
    chain_.HostFrame(frame, encoded.size);
  }

 private:
  void Command(const std::array<float, 3>& set_point_A) {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    for (std::size_t k = 0; k < 3; ++k) command.set_point_A[k] = set_point_A[k];
    command.time_to_live_ms = device::TimeToLive_ms(command.set_point_A);
    Send(command);
  }

  void Listen() {
    std::uint8_t bytes[wire::kFrameSizeMax];
    for (std::size_t size = 0; (size = chain_.NextFrame(bytes, sizeof bytes)) != 0;) {
      wire::FrameView view;
      wire::Arm arm;
      if (wire::OpenFrame(bytes, size, view) != wire::Status::kOk) continue;
      if (wire::Decode(view, arm) == wire::Status::kOk && arm.step == wire::ArmStep::kChallenge) nonce_ = arm.nonce;
    }
  }

  Chain& chain_;
  std::uint16_t seq_ = 0;
  std::optional<std::uint32_t> nonce_;
};

}  // namespace omni::hil
