// Current and voltage of one coil: INA260 on I2C, configured here; the board reads it and moves its alert in transfers
// of its own. Its 2 milliohm shunt is internal and trimmed, so a count is 1.25 mA or 1.25 mV for every chip. Rated for
// 15 A continuously.
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

template <class Bus>
class Ina260 {
 public:
  // Address: 0x40 to 0x4F, by the pins A1 and A0.
  Ina260(Bus& bus, std::uint8_t address) noexcept : bus_(bus), address_(address) {}

  // Identity, reset, configuration, alert; everything read back. `limit_counts` > 0, 1.25 mA each: the alert pin goes
  // low and stays low once a conversion is above it. Errors: kNack, kTimeout, kWrongIdentity, kNotTaken.
  ChipStatus Start(ina260::Mode mode, std::int16_t limit_counts) noexcept {
    const auto config = static_cast<std::uint16_t>(ina260::kConfigFixed | static_cast<std::uint16_t>(mode));
    const auto limit = static_cast<std::uint16_t>(limit_counts);
    constexpr std::uint16_t kMask = ina260::kAlertOverCurrent | ina260::kAlertLatch;
    constexpr std::uint16_t kMaskSettings = ina260::kAlertSelect | ina260::kAlertInverted | ina260::kAlertLatch;
    started_ = false;
    pointer_ = kUnknown;
    ChipStatus status = CheckIdentity();
    if (status == ChipStatus::kOk) {
      status = WriteRegister(ina260::kConfig, ina260::kConfigReset | ina260::kConfigFixed);
    }
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kConfig, config);
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kConfig, config, 0xFFFF);
    // The alert is off while its limit changes; otherwise the old limit would trigger.
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kMaskEnable, ina260::kAlertLatch);
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kAlertLimit, limit);
    if (status == ChipStatus::kOk) status = WriteRegister(ina260::kMaskEnable, kMask);
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kAlertLimit, limit, 0xFFFF);
    if (status == ChipStatus::kOk) status = CheckRegister(ina260::kMaskEnable, kMask, kMaskSettings);
    started_ = status == ChipStatus::kOk;
    return status;
  }

  bool started() const noexcept { return started_; }

 private:
  static constexpr int kUnknown = -1;

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

  ChipStatus CheckRegister(std::uint8_t number, std::uint16_t wanted, std::uint16_t mask) noexcept {
    std::uint16_t value = 0;
    const ChipStatus status = ReadRegister(number, value);
    if (status != ChipStatus::kOk) return status;
    return (value & mask) == (wanted & mask) ? ChipStatus::kOk : ChipStatus::kNotTaken;
  }

  // The chip keeps its register pointer: what was written is read back with three bytes, not five.
  ChipStatus ReadRegister(std::uint8_t number, std::uint16_t& value) noexcept {
    std::uint8_t in[2] = {};
    const BusStatus status = bus_.Transfer(address_, &number, pointer_ == number ? 0 : 1, in, sizeof in);
    pointer_ = number;
    if (status == BusStatus::kOk) value = static_cast<std::uint16_t>((in[0] << 8) | in[1]);
    return ToChipStatus(status);
  }

  ChipStatus WriteRegister(std::uint8_t number, std::uint16_t value) noexcept {
    const std::uint8_t out[3] = {number, static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
    const BusStatus status = bus_.Transfer(address_, out, sizeof out, nullptr, 0);
    pointer_ = number;
    return ToChipStatus(status);
  }

  Bus& bus_;
  std::uint8_t address_;
  bool started_ = false;
  int pointer_ = kUnknown;
};

}  // namespace omni::drivers
