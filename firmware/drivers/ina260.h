// Current and voltage of one coil: INA260 on I2C. Its 2 milliohm shunt is internal and trimmed, so a count is
// 1.25 mA or 1.25 mV for every chip. Rated for 15 A continuously.
//
// Bus policy:
//   BusStatus Transfer(std::uint8_t address, const std::uint8_t* out, std::size_t out_size, std::uint8_t* in,
//                      std::size_t in_size) noexcept;
//     Start, writes `out_size` bytes if any, (repeated) start, reads `in_size` bytes if any, stop. `address` is the
//     seven-bit one. Must return in bounded time, even if a line is held low. kNack: the chip did not acknowledge.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/drivers/chip_status.h"
#include "firmware/drivers/ina260_registers.h"

namespace omni::drivers {

// The chip's comparison is signed and has one limit: for a coil whose current may have either sign, select the side to
// which it is driven.
enum class AlertSide : std::uint8_t { kPositive = 0, kNegative = 1 };

template <class Bus>
class Ina260 {
 public:
  // Address: 0x40 to 0x4F, by the pins A1 and A0.
  Ina260(Bus& bus, std::uint8_t address) noexcept : bus_(bus), address_(address) {}

  // Identity, reset, configuration, alert; everything read back. `limit_counts` > 0, 1.25 mA each: the alert pin goes
  // low and stays low once a conversion is beyond it. Errors: kNack, kTimeout, kWrongIdentity, kNotTaken.
  ChipStatus Start(ina260::Mode mode, std::int16_t limit_counts) noexcept {
    started_ = false;
    pointer_known_ = false;
    config_ = static_cast<std::uint16_t>(ina260::kConfigFixed | static_cast<std::uint16_t>(mode));
    limit_counts_ = limit_counts;
    side_ = AlertSide::kPositive;
    ChipStatus status = CheckIdentity();
    if (status == ChipStatus::kOk) {
      status = WriteRegister(ina260::kConfig, ina260::kConfigReset | ina260::kConfigFixed);
    }
    if (status == ChipStatus::kOk) status = Configure();
    started_ = status == ChipStatus::kOk;
    return Count(status);
  }

  // Signed, 1.25 mA. The chip keeps its register pointer: repeated reads cost three bytes, not five.
  ChipStatus ReadCurrent(std::int16_t& counts) noexcept {
    std::uint16_t value = 0;
    const ChipStatus status = ReadMeasured(ina260::kCurrent, value);
    if (status == ChipStatus::kOk) counts = static_cast<std::int16_t>(value);
    return status;
  }

  // 1.25 mV, at the chip's voltage pin.
  ChipStatus ReadVoltage(std::uint16_t& counts) noexcept { return ReadMeasured(ina260::kVoltage, counts); }

  // True if the alert has triggered. Reading ends the latch, so call it while the bridge is off. Also detects a chip
  // that has lost its alert (kNotTaken): Verify then restores it.
  ChipStatus ReadAlert(bool& struck) noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    std::uint16_t mask = 0;
    const ChipStatus status = ReadRegister(ina260::kMaskEnable, mask);
    if (status != ChipStatus::kOk) return Count(status);
    struck = (mask & ina260::kAlertFlag) != 0;
    return Count((mask & kMaskSettings) == WantedMask() ? ChipStatus::kOk : ChipStatus::kNotTaken);
  }

  // To be called when the sign of the drive changes: three writes, without the time to read them back (Verify does).
  // Does nothing when the side is the same.
  ChipStatus SetAlertSide(AlertSide side) noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    if (side == side_) return ChipStatus::kOk;
    side_ = side;
    const ChipStatus status = WriteAlert();
    started_ = status == ChipStatus::kOk;  // a half-set alert is invalid: start again
    return Count(status);
  }

  // Checks the configuration. If a brown-out has cleared it, the chip is configured again (kChanged). Otherwise a
  // latched alert is not touched.
  ChipStatus Verify() noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    std::uint16_t config = 0;
    std::uint16_t limit = 0;
    ChipStatus status = ReadRegister(ina260::kConfig, config);
    if (status == ChipStatus::kOk) status = ReadRegister(ina260::kAlertLimit, limit);
    if (status != ChipStatus::kOk) return Count(status);
    if (config == config_ && limit == WantedLimit()) return ChipStatus::kOk;
    started_ = false;
    status = CheckIdentity();
    if (status == ChipStatus::kOk) status = Configure();
    started_ = status == ChipStatus::kOk;
    return Count(started_ ? ChipStatus::kChanged : status);
  }

  bool started() const noexcept { return started_; }
  const ChipCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::uint16_t kMaskSettings = ina260::kAlertSelect | ina260::kAlertInverted | ina260::kAlertLatch;

  std::uint16_t WantedMask() const noexcept {
    const std::uint16_t select = side_ == AlertSide::kPositive ? ina260::kAlertOverCurrent : ina260::kAlertUnderCurrent;
    return static_cast<std::uint16_t>(select | ina260::kAlertLatch);
  }

  std::uint16_t WantedLimit() const noexcept {
    return static_cast<std::uint16_t>(side_ == AlertSide::kPositive ? limit_counts_ : -limit_counts_);
  }

  ChipStatus CheckIdentity() noexcept {
    std::uint16_t manufacturer = 0;
    std::uint16_t die = 0;
    ChipStatus status = ReadRegister(ina260::kManufacturerId, manufacturer);
    if (status == ChipStatus::kOk) status = ReadRegister(ina260::kDieId, die);
    if (status != ChipStatus::kOk) return status;
    const bool same = manufacturer == ina260::kManufacturer &&
                      (die & static_cast<std::uint16_t>(~ina260::kDieRevisionMask)) == ina260::kDie;
    return same ? ChipStatus::kOk : ChipStatus::kWrongIdentity;
  }

  ChipStatus Configure() noexcept {
    ChipStatus status = WriteRegister(ina260::kConfig, config_);
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kConfig, config_, 0xFFFF);
    if (status == ChipStatus::kOk) status = WriteAlert();
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kAlertLimit, WantedLimit(), 0xFFFF);
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kMaskEnable, WantedMask(), kMaskSettings);
    return status;
  }

  // The alert is off while its limit changes sides; otherwise the old side would trigger at the new limit.
  ChipStatus WriteAlert() noexcept {
    ChipStatus status = WriteRegister(ina260::kMaskEnable, ina260::kAlertLatch);
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kAlertLimit, WantedLimit());
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kMaskEnable, WantedMask());
    return status;
  }

  ChipStatus CheckRegister(std::uint8_t number, std::uint16_t wanted, std::uint16_t mask) noexcept {
    std::uint16_t value = 0;
    const ChipStatus status = ReadRegister(number, value);
    if (status != ChipStatus::kOk) return status;
    return (value & mask) == (wanted & mask) ? ChipStatus::kOk : ChipStatus::kNotTaken;
  }

  ChipStatus ReadMeasured(std::uint8_t number, std::uint16_t& value) noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    return Count(ReadRegister(number, value));
  }

  ChipStatus ReadRegister(std::uint8_t number, std::uint16_t& value) noexcept {
    std::uint8_t in[2] = {};
    const bool there = pointer_known_ && pointer_ == number;
    const BusStatus status = bus_.Transfer(address_, &number, there ? 0 : 1, in, sizeof in);
    pointer_known_ = status == BusStatus::kOk;
    pointer_ = number;
    if (status == BusStatus::kOk) value = static_cast<std::uint16_t>((in[0] << 8) | in[1]);
    return ToChipStatus(status);
  }

  ChipStatus WriteRegister(std::uint8_t number, std::uint16_t value) noexcept {
    const std::uint8_t out[3] = {number, static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
    const BusStatus status = bus_.Transfer(address_, out, sizeof out, nullptr, 0);
    pointer_known_ = status == BusStatus::kOk;
    pointer_ = number;
    return ToChipStatus(status);
  }

  ChipStatus Count(ChipStatus status) noexcept {
    if (status == ChipStatus::kNack || status == ChipStatus::kTimeout) ++counters_.bus_errors;
    if (status == ChipStatus::kWrongIdentity) ++counters_.wrong_identity;
    if (status == ChipStatus::kChanged || status == ChipStatus::kNotTaken) ++counters_.changed;
    return status;
  }

  Bus& bus_;
  std::uint8_t address_;
  bool started_ = false;
  bool pointer_known_ = false;
  std::uint8_t pointer_ = 0;
  std::uint16_t config_ = 0;
  std::int16_t limit_counts_ = 0;
  AlertSide side_ = AlertSide::kPositive;
  ChipCounters counters_;
};

}  // namespace omni::drivers
