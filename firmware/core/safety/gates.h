// What must be right before a bridge is driven: the arming, the command, the output.
#pragma once

#include <cstdint>

#include "firmware/core/board_io.h"
#include "firmware/wire/messages.h"

namespace omni::firmware {

// Arming in two steps: a request is answered with a nonce, and returning it within 100 ms arms, once.
class Arming {
 public:
  // `seed`: must differ at every reset, or nonces repeat.
  explicit Arming(std::uint32_t seed) noexcept : state_(seed) {}

  std::uint32_t Challenge(std::uint64_t now_us) noexcept;
  // Right or wrong, the nonce is used up.
  bool Confirm(std::uint32_t nonce, std::uint64_t now_us) noexcept;

 private:
  std::uint32_t state_;
  std::uint32_t nonce_ = 0;
  std::uint64_t asked_us_ = 0;
  bool is_open_ = false;
};

// Which COMMAND may act: newer than all before it, and within its time to live. Sequence numbers wrap after a minute,
// so the command's host clock is checked as well. docs/theory/firmware.md (8.1), (8.2)
class CommandGate {
 public:
  // False: a duplicate, a replay or late. `now_us`: of the previous step, so that lives end early rather than late.
  bool Accept(const wire::Command& command, std::uint16_t seq, std::uint64_t now_us) noexcept;

  // For a new host, or one that was disconnected: any sequence may begin.
  void ResetSequence() noexcept { has_order_ = false; }
  // On arming: the first command may take a whole time to live.
  void StartWaiting(std::uint64_t now_us) noexcept;

  bool is_alive(std::uint64_t now_us) const noexcept { return has_life_ && now_us - heard_us_ <= live_us_; }

  std::uint16_t seq() const noexcept { return seq_; }
  std::uint64_t host_us() const noexcept { return host_us_; }
  std::uint64_t heard_us() const noexcept { return heard_us_; }

 private:
  bool has_order_ = false;
  bool has_life_ = false;
  std::uint16_t seq_ = 0;
  std::uint64_t host_us_ = 0;
  std::uint64_t heard_us_ = 0;
  std::uint64_t live_us_ = 0;
};

// A second check of the outputs to the bridges, independent of Drive and of the core's current state: a non-zero duty
// only while armed, in the self-test, or in the ramp that ends an armed state. docs/theory/firmware.md (6.5)
class OutputCheck {
 public:
  // Notes each state that the core enters, in order.
  void SetState(wire::State state) noexcept { state_ = state; }

  // Every step, last. False: a bridge would be driven that must not be.
  bool Allows(const Outputs& outputs) noexcept;

 private:
  wire::State state_ = wire::State::kBoot;
  int left_steps_ = 0;  // of the ramp
};

}  // namespace omni::firmware
