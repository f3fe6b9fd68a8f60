// Registers of the magnetometer LIS3MDL [ST DocID024204: 5.2 SPI, 6 register mapping, 7 register description].
#pragma once

#include <cstdint>

namespace omni::drivers::lis3mdl {

// First byte on SPI [5.2]: read, count the address up, six bits of address. Mode 3 (CPOL = CPHA = 1), at most 10 MHz.
// With its chip select high the chip listens for I2C on the same pins; in mode 3 data change only while the clock is
// low, which is no I2C start, so traffic to the other chips of the bus does not wake it.
constexpr std::uint8_t kSpiRead = 0x80;
constexpr std::uint8_t kSpiIncrement = 0x40;

constexpr std::uint8_t kWhoAmI = 0x0F;
constexpr std::uint8_t kCtrl1 = 0x20;
constexpr std::uint8_t kCtrl2 = 0x21;
constexpr std::uint8_t kCtrl3 = 0x22;
constexpr std::uint8_t kCtrl4 = 0x23;
constexpr std::uint8_t kCtrl5 = 0x24;
constexpr std::uint8_t kStatus = 0x27;
constexpr std::uint8_t kOutX = 0x28;  // six bytes, low byte first; a burst goes from the last to the first of them

constexpr std::uint8_t kIdentity = 0x3D;  // WHO_AM_I

// CTRL_REG1: OM = 00 low power, FAST_ODR: in low power 1000 Hz.
constexpr std::uint8_t kCtrl1FastOdr = 0x02;
constexpr std::uint8_t kCtrl1SelfTest = 0x01;
// CTRL_REG2: FS = 11, +-16 gauss.
constexpr std::uint8_t kCtrl2FullScale16 = 0x60;
constexpr std::uint8_t kCtrl2SoftReset = 0x04;  // clears itself
// CTRL_REG3: MD = 00, continuous conversion, 4-wire SPI.
constexpr std::uint8_t kCtrl3Continuous = 0x00;
constexpr std::uint8_t kCtrl3Reset = 0x03;  // after reset: powered down
// CTRL_REG4: OMZ = 00, z in low power too; low byte at the lower address.
constexpr std::uint8_t kCtrl4LowPower = 0x00;
// CTRL_REG5: BDU, a sample's high and low bytes belong together.
constexpr std::uint8_t kCtrl5BlockDataUpdate = 0x40;

// STATUS_REG.
constexpr std::uint8_t kStatusOverrun = 0x80;  // ZYXOR: a sample was overwritten unread
constexpr std::uint8_t kStatusNew = 0x08;      // ZYXDA

constexpr std::uint8_t kConfiguration[5] = {kCtrl1FastOdr, kCtrl2FullScale16, kCtrl3Continuous, kCtrl4LowPower,
                                            kCtrl5BlockDataUpdate};
static_assert(kConfiguration[0] == 0x02 && kConfiguration[1] == 0x60, "1 kHz, low power, +-16 gauss");

// At +-16 gauss [2.1]: 1711 counts a gauss; a gauss is 1e-4 T.
constexpr int kCountsPerGauss = 1711;
constexpr std::int16_t kFullScaleCounts = 27376;
static_assert(kFullScaleCounts == 16 * kCountsPerGauss, "16 gauss");

// Self-test answer, |with - without|, per axis [2.1, stated at +-12 gauss]: x and y 1 to 3 gauss, z 0.1 to 1 gauss.
struct SelfTestRange {
  int min_counts, max_counts;
};
constexpr SelfTestRange kSelfTest[3] = {{kCountsPerGauss, 3 * kCountsPerGauss},
                                        {kCountsPerGauss, 3 * kCountsPerGauss},
                                        {kCountsPerGauss / 10, kCountsPerGauss}};
// How long after switching the self-test its answer is settled.
constexpr std::uint32_t kSelfTestSettle_us = 60'000;

}  // namespace omni::drivers::lis3mdl
