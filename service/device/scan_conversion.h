// Wire units -> seam units: HELLO to DeviceInfo, TELEMETRY to HallScan.
#pragma once

#include <cstdint>
#include <string>

#include "firmware/wire/messages.h"
#include "service/base/hall_scan.h"
#include "service/base/result.h"

namespace omni::device {

// A base as its HELLO describes it.
struct DeviceInfo {
  std::string serial;
  std::uint16_t firmware_version = 0;
  bool simulation = false;
  bool clock_is_host = false;  // its stamps are CLOCK_MONOTONIC
  bool arming = false;         // its coils carry no current until it is armed
  double field_lsb_T = 0;
  double field_range_T = 0;  // of its sensors, per axis: larger readings are saturated
  double current_max_A = 0;
  std::uint64_t calibration_hash = 0;
};

// Which clock's stamps a transport accepts.
enum class Clocks : std::uint8_t { kHostOnly, kAny };

// Refuses a base whose protocol or clock the transport does not support, or whose scales are not plausible; the message
// says which and what to do.
base::Result<DeviceInfo> InfoFromHello(const wire::Hello& hello, Clocks clocks = Clocks::kHostOnly);

// `t_device_us` is the instant of the newest Hall sample on CLOCK_MONOTONIC. A sensor whose age is 255 units ("that or
// older") and an unknown one are reported with that age and no fresh bit; the caller decides how to use it.
base::HallScan ScanFromTelemetry(const DeviceInfo& info, const wire::Telemetry& telemetry, std::uint64_t t_device_us,
                                 std::uint64_t sequence) noexcept;

// Continues the 16-bit sequence of the wire in 64 bits and counts the gaps.
class SequenceCounter {
 public:
  // False: `seq` is not newer than the last one; nothing changes.
  bool Advance(std::uint16_t seq) noexcept {
    if (!started_) {
      started_ = true;
      sequence_ = seq;
      return true;
    }
    const std::int32_t distance = wire::SeqDistance(static_cast<std::uint16_t>(sequence_), seq);
    if (distance <= 0) return false;
    sequence_ += static_cast<std::uint64_t>(distance);
    missed_ += static_cast<std::uint64_t>(distance - 1);
    return true;
  }
  std::uint64_t sequence() const noexcept { return sequence_; }
  std::uint64_t missed() const noexcept { return missed_; }

 private:
  std::uint64_t sequence_ = 0;
  std::uint64_t missed_ = 0;
  bool started_ = false;
};

}  // namespace omni::device
