// Registers of the current and voltage monitor INA260 [TI SBOS656C, 8.6]. All are 16 bits, high byte first.
#pragma once

#include <cstdint>

namespace omni::drivers::ina260 {

constexpr std::uint8_t kConfig = 0x00;          // 8.6.1
constexpr std::uint8_t kCurrent = 0x01;         // 8.6.2, signed
constexpr std::uint8_t kVoltage = 0x02;         // 8.6.3, never negative
constexpr std::uint8_t kMaskEnable = 0x06;      // 8.6.5; reading it ends a latched alert
constexpr std::uint8_t kAlertLimit = 0x07;      // 8.6.6, in the units of what it limits
constexpr std::uint8_t kManufacturerId = 0xFE;  // 8.6.7
constexpr std::uint8_t kDieId = 0xFF;           // 8.6.8; low four bits: revision

constexpr std::uint16_t kManufacturer = 0x5449;  // "TI"
constexpr std::uint16_t kDie = 0x2270;
constexpr std::uint16_t kDieRevisionMask = 0x000F;

// Configuration: bit 15 reset; 14:12 always 110; 11:9 averages; 8:6 and 5:3 conversion times of voltage and current;
// 2:0 mode. Zero in the first three: one sample, 140 us each.
constexpr std::uint16_t kConfigReset = 0x8000;
constexpr std::uint16_t kConfigFixed = 0x6000;
constexpr std::uint16_t kConfigAfterReset = 0x6127;
enum class Mode : std::uint16_t {
  kCurrentOnly = 5,        // a new current every 140 us, no voltage
  kCurrentAndVoltage = 7,  // in turn: each new every 280 us
};

// Mask/enable. Only one limit can be active; a comparison is signed.
constexpr std::uint16_t kAlertOverCurrent = 0x8000;   // OCL: current above the limit
constexpr std::uint16_t kAlertUnderCurrent = 0x4000;  // UCL: current below the limit
constexpr std::uint16_t kAlertSelect = 0xFC00;
constexpr std::uint16_t kAlertFlag = 0x0010;      // AFF: the alert has triggered
constexpr std::uint16_t kAlertInverted = 0x0002;  // APOL; 0: the open-drain pin goes low
constexpr std::uint16_t kAlertLatch = 0x0001;     // LEN: stays until mask/enable is read

// Scales, fixed by the resistor inside [8.5.1]: nothing to calibrate.
constexpr float kCurrentUnit_A = 1.25e-3F;
constexpr float kVoltageUnit_V = 1.25e-3F;

// Nearest count of a current, |current_A| <= 40.
constexpr std::int16_t CurrentCounts(float current_A) noexcept {
  const float counts = current_A / kCurrentUnit_A;
  return static_cast<std::int16_t>(counts < 0 ? counts - 0.5F : counts + 0.5F);
}

// Above 400 kHz the chip requires its filters to be switched first: start, this byte (not acknowledged) at up to 400
// kHz, then repeated starts at up to 2.94 MHz until a stop [8.5.3.3.1]. That is the bus policy's task.
constexpr std::uint8_t kHighSpeedMasterCode = 0x08;

}  // namespace omni::drivers::ina260
