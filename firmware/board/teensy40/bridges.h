// Three H bridges on FlexPWM2: 20 kHz, edge-aligned, low when nothing is written. Its four fault inputs (a line per
// coil, and the emergency stop) force all three outputs low in hardware, and hold them until the lines are good and
// nothing is driven [RM FlexPWM, fault protection; RM XBAR].
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/board/teensy40/chip/pins.h"

namespace omni::board {

constexpr int kBridges = 3;
constexpr std::uint32_t kPwm_Hz = 20'000;  // a multiple of the telemetry rate
constexpr std::uint16_t kPwmTicks = kBus_Hz / kPwm_Hz;
constexpr std::uint32_t kPwmPeriod_us = 1'000'000 / kPwm_Hz;
constexpr std::uint16_t kDutyFull = 32767;

// Ticks high of a duty in 0..32767; all of the period at full duty. Larger ones count as full.
constexpr std::uint16_t PwmHighTicks(std::uint16_t duty) noexcept {
  return duty >= kDutyFull
             ? kPwmTicks
             : static_cast<std::uint16_t>((static_cast<std::uint32_t>(duty) * kPwmTicks + kDutyFull / 2) / kDutyFull);
}

class Bridges {
 public:
  // All outputs low, faults routed and armed, then the timer runs.
  void Start() noexcept;

  // Bit k: coil k's line is low, or was since the faults were last cleared.
  std::uint8_t CoilFaults() const noexcept;
  // The switch is open, or was since then.
  bool EmergencyStop() const noexcept;
  // Bit k: coil k's line is low at present.
  std::uint8_t CoilFaultLines() const noexcept;

  // Ends the hold of faults whose lines are good. Call only while nothing is driven: outputs follow the next period.
  void ClearFaults() noexcept;

  bool nothing_driven() const noexcept { return driven_ == 0; }

  // PWM and time run from one crystal: periods are counted from it. 64 bits: time is continuous when a timer wraps.
  void SetTime(std::uint64_t now_us) noexcept { periods_ = static_cast<std::uint32_t>(now_us / kPwmPeriod_us); }

  // firmware/drivers/g2_driver.h
  class Pins {
   public:
    Pins(Bridges& bridges, int index) noexcept : bridges_(bridges), index_(index) {}
    void SetDuty(std::uint16_t duty) noexcept { bridges_.SetDuty(index_, duty); }
    void SetDirection(bool negative) noexcept;
    void SetAwake(bool awake) noexcept;
    bool FaultIsLow() noexcept { return (bridges_.CoilFaults() >> index_ & 1) != 0; }
    std::uint32_t PwmPeriods() noexcept { return bridges_.periods_; }

   private:
    Bridges& bridges_;
    int index_;
  };

 private:
  void SetDuty(int index, std::uint16_t duty) noexcept;

  std::uint32_t periods_ = 0;
  std::uint8_t driven_ = 0;  // bit k: its duty is not 0
};

// The fan's own output on FlexPWM4: 25 kHz, as four-wire fans want it [Intel, 4-Wire PWM Controlled Fans, 2.1.1].
class FanPwm {
 public:
  void Start() noexcept;
  void Set(std::uint8_t of_255) noexcept;
};

}  // namespace omni::board
