// How long a base waits for the answer to a scan: from the scan's stamp to the control step in which its set-points
// take effect. Both instants are on the base's clock (TELEMETRY's t_device_us and ack_rx_device_us): nothing is mapped.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::device {

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
