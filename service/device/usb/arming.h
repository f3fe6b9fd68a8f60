// Arms a base in two steps (wire::Arm) when it is opened, and again after it disarmed because of the host. After any
// other fault it is never rearmed automatically, not even when the fault is gone: the user has to check the base.
#pragma once

#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::device {

class Arming {
 public:
  static constexpr std::int64_t kAnswer_ns = 200'000'000;  // how long an answer may take; the nonce is good for 100 ms
  static constexpr std::int64_t kPause_ns = 100'000'000;   // after a refusal

  void OnTelemetry(const wire::Telemetry& telemetry, std::int64_t t_ns) noexcept;
  // False: an unsolicited answer; nothing changes.
  bool OnArm(const wire::Arm& arm, std::int64_t t_ns) noexcept;
  // True: `arm` is to be sent now.
  bool Next(std::int64_t t_ns, wire::Arm& arm) noexcept;

  // By the newest telemetry: set-points take effect.
  bool armed() const noexcept { return armed_; }
  // A fault that is not the host's occurred since the start; the user has to check it (omni device selftest).
  bool held() const noexcept { return held_; }

 private:
  enum class Phase : std::uint8_t { kRest, kAsk, kAsked, kConfirm, kConfirmed };
  void Rest(std::int64_t until_ns) noexcept;

  Phase phase_ = Phase::kRest;
  bool armed_ = false;
  bool held_ = false;
  std::uint32_t nonce_ = 0;
  std::int64_t since_ns_ = 0;  // of the phase
  std::int64_t not_before_ns_ = 0;
};

}  // namespace omni::device
