// What set-points need on their way to a base: that it is armed, how long they live, when they take effect.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::device {

// Arms a base in two steps (wire::Arm) when it is opened, and again after it disarmed because of the host. After any
// other fault it is never rearmed automatically, not even when the fault is gone: the user has to check the base.
class Arming {
 public:
  static constexpr std::int64_t kAnswer_ns = 200'000'000;  // how long an answer may take; the nonce is good for 100 ms
  static constexpr std::int64_t kPause_ns = 100'000'000;   // after a refusal

  void OnTelemetry(const wire::Telemetry& telemetry, std::int64_t t_ns) noexcept;
  // False: an unsolicited answer; nothing changes.
  bool OnArm(const wire::Arm& arm, std::int64_t t_ns) noexcept;
  // True: `arm` is to be sent now.
  bool NextToSend(std::int64_t t_ns, wire::Arm& arm) noexcept;

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

// How far after the newest command that the base has from an earlier program the sequence begins: beyond the frames of
// other types that came after it, and well within the range that serial-number arithmetic considers newer.
constexpr std::uint16_t kSeqMargin = 1000;

// How long a base may act on a COMMAND of this host when no other one follows. 20 ms after a silent host's last COMMAND
// no current may be left: this life, the control step that detects its end (0.25 ms), a ramp of at most 5 ms, and the
// coils' own lag; measured in the table "Silence" of docs/protocol/faults.md. At 1 kHz eleven commands in a row may be
// late or lost before the base disarms; a force held for longer than that would be a wrong one anyway.
// docs/decisions/0010
constexpr std::uint16_t kCommandTimeToLive_ms = 12;

// A zero current may live as long as the wire allows, for there is nothing to remove: the base of a service that rests,
// and therefore sends only every 16 ms, stays armed.
constexpr std::uint16_t TimeToLive_ms(const float (&set_point_A)[wire::kCoils]) noexcept {
  for (const float current_A : set_point_A) {
    if (current_A != 0) return kCommandTimeToLive_ms;
  }
  return wire::kTimeToLiveMax_ms;
}
static_assert(kCommandTimeToLive_ms >= 1 && kCommandTimeToLive_ms <= wire::kTimeToLiveMax_ms, "range of the wire");

// How long a base waits for the answer to a scan: from the scan's stamp to the control step in which its set-points
// take effect. Both instants are on the base's clock (TELEMETRY's t_device_us and ack_rx_device_us): nothing is mapped.
class ResponseTime {
 public:
  // A COMMAND with this number is sent; it was computed from the scan with that stamp.
  void OnSent(std::uint16_t seq, std::uint64_t t_device_us) noexcept;

  void OnTelemetry(const wire::Telemetry& telemetry) noexcept;

  // About one answer in a hundred is later than this, ns: it rises within tens of answers and falls within seconds.
  // 0: no answer yet.
  std::int64_t late_ns() const noexcept { return static_cast<std::int64_t>(1e3 * late_us_); }

 private:
  static constexpr std::size_t kKept = 64;
  struct Sent {
    std::uint16_t seq = 0;
    bool waits = false;
    std::uint64_t t_device_us = 0;
  };
  std::array<Sent, kKept> sent_{};
  double late_us_ = 0;
};

}  // namespace omni::device
