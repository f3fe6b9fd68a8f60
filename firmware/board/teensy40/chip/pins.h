// Every signal of the base and the pad it uses, in one table: the reference for wiring and the source for start-up.
// Pads of Teensy pins: [PJRC, Teensy 4.0 schematic]; functions: [RM External Signals and Pin Multiplexing].
#pragma once

#include <cstdint>

namespace omni::board {

// The pad's multiplexer register; the pad control register is at a fixed distance [RM IOMUX Controller].
enum class Pad : std::uint16_t {
  kEmc04 = 0x024,
  kEmc05 = 0x028,
  kEmc06 = 0x02C,
  kEmc08 = 0x034,
  kAdB0_02 = 0x0C4,
  kAdB0_03 = 0x0C8,
  kAdB0_12 = 0x0EC,
  kAdB1_00 = 0x0FC,
  kAdB1_01 = 0x100,
  kAdB1_02 = 0x104,
  kAdB1_03 = 0x108,
  kAdB1_06 = 0x114,
  kAdB1_07 = 0x118,
  kAdB1_08 = 0x11C,
  kAdB1_09 = 0x120,
  kAdB1_10 = 0x124,
  kAdB1_11 = 0x128,
  kB0_00 = 0x13C,
  kB0_01 = 0x140,
  kB0_02 = 0x144,
  kB0_03 = 0x148,
  kB0_10 = 0x164,
  kB0_11 = 0x168,
  kB1_00 = 0x17C,
  kB1_01 = 0x180,
};
constexpr std::uint32_t kIomuxBase = 0x401F8000;
constexpr std::uint32_t kPadControlOffset = 0x1F0;

// Pad control [RM IOMUX Controller, SW_PAD_CTL]. Drive strength 4: about 38 ohm at 3.3 V.
namespace pad {
constexpr std::uint32_t kDrive = 4U << 3;
constexpr std::uint32_t kMedium = 2U << 6;
constexpr std::uint32_t kOpenDrain = 1U << 11;
constexpr std::uint32_t kPull = 3U << 12;  // pull, not keeper
constexpr std::uint32_t kDown100k = kPull;
constexpr std::uint32_t kUp22k = kPull | (3U << 14);
constexpr std::uint32_t kHysteresis = 1U << 16;

constexpr std::uint32_t kOutput = kDrive | kMedium | kDown100k;  // pulled down until driven
constexpr std::uint32_t kOutputIdleHigh = kDrive | kMedium | kUp22k;
constexpr std::uint32_t kInputUp = kUp22k | kHysteresis;
constexpr std::uint32_t kInputDown = kDown100k | kHysteresis;
constexpr std::uint32_t kBus = kDrive | kMedium | kUp22k | kOpenDrain | kHysteresis;  // in addition to 2.2 kohm outside
}  // namespace pad

constexpr std::uint8_t kAsGpio = 5;
constexpr std::uint8_t kInputOn = 0x10;  // SION: the input path stays on whatever the function

enum class Signal : std::uint8_t {
  kBridgePwm0,
  kBridgePwm1,
  kBridgePwm2,
  kBridgeDirection0,
  kBridgeDirection1,
  kBridgeDirection2,
  kBridgeAwake0,
  kBridgeAwake1,
  kBridgeAwake2,
  kCoilFault0,
  kCoilFault1,
  kCoilFault2,
  kEmergencyStop,
  kHallSelectOff,
  kHallAddress0,
  kHallAddress1,
  kHallAddress2,
  kHallClock,
  kHallOut,
  kHallIn,
  kCurrentClock,
  kCurrentData,
  kFanPwm,
  kFanTach,
  kLed,
};
constexpr int kSignals = static_cast<int>(Signal::kLed) + 1;

struct Pin {
  Signal signal;
  std::uint8_t teensy;  // number on the board's edge; 24: a pad below it
  Pad pad;
  std::uint8_t function;  // ALTn, with kInputOn where the pad is read too
  std::uint32_t control;
  std::uint16_t input_select;  // register offset; 0: none
  std::uint8_t input_value;
  std::uint8_t port, bit;  // GPIO1 to GPIO4; port 0: no plain input or output
  bool output;
};

// Reasons for this assignment:
// - the three PWM outputs belong to one FlexPWM2, which has four fault inputs, one per coil and the emergency stop: a
//   fault brakes all three without the processor;
// - the fault inputs reach FlexPWM2 through the crossbar, hence pads with XBAR1_INOUTnn;
// - a coil's fault line is the bridge's FLT and that coil's INA260 ALERT, both open drain, tied together;
// - the emergency stop is a normally closed switch to ground: pressed, unplugged or broken reads high and stops;
// - too few pins for eight chip selects: a 74HC138 decodes three address lines, enabled low by kHallSelectOff.
//   Pin 13 is the clock of that bus and also the board's orange LED, which therefore glows while sensors are read;
// - GPT2's capture input measures the fan;
// - awake lines are low from reset on, so the bridges sleep; README.md lists the external resistors for that.
constexpr Pin kPins[] = {
    {Signal::kBridgePwm0, 4, Pad::kEmc06, 1, pad::kOutput, 0, 0, 4, 6, true},   // FLEXPWM2_PWMA00
    {Signal::kBridgePwm1, 5, Pad::kEmc08, 1, pad::kOutput, 0, 0, 4, 8, true},   // FLEXPWM2_PWMA01
    {Signal::kBridgePwm2, 6, Pad::kB0_10, 2, pad::kOutput, 0, 0, 2, 10, true},  // FLEXPWM2_PWMA02
    {Signal::kBridgeDirection0, 7, Pad::kB1_01, kAsGpio, pad::kOutput, 0, 0, 2, 17, true},
    {Signal::kBridgeDirection1, 1, Pad::kAdB0_02, kAsGpio, pad::kOutput, 0, 0, 1, 2, true},
    {Signal::kBridgeDirection2, 9, Pad::kB0_11, kAsGpio, pad::kOutput, 0, 0, 2, 11, true},
    {Signal::kBridgeAwake0, 14, Pad::kAdB1_02, kAsGpio, pad::kOutput, 0, 0, 1, 18, true},
    {Signal::kBridgeAwake1, 16, Pad::kAdB1_07, kAsGpio, pad::kOutput, 0, 0, 1, 23, true},
    {Signal::kBridgeAwake2, 17, Pad::kAdB1_06, kAsGpio, pad::kOutput, 0, 0, 1, 22, true},
    {Signal::kCoilFault0, 2, Pad::kEmc04, 3, pad::kInputUp, 0x61C, 0, 0, 0, false},     // XBAR1_INOUT06
    {Signal::kCoilFault1, 3, Pad::kEmc05, 3, pad::kInputUp, 0x620, 0, 0, 0, false},     // XBAR1_INOUT07
    {Signal::kCoilFault2, 0, Pad::kAdB0_03, 1, pad::kInputUp, 0x62C, 1, 0, 0, false},   // XBAR1_INOUT17
    {Signal::kEmergencyStop, 8, Pad::kB1_00, 1, pad::kInputUp, 0x644, 1, 0, 0, false},  // XBAR1_INOUT14
    {Signal::kHallSelectOff, 10, Pad::kB0_00, kAsGpio, pad::kOutputIdleHigh, 0, 0, 2, 0, true},
    {Signal::kHallAddress0, 20, Pad::kAdB1_10, kAsGpio, pad::kOutput, 0, 0, 1, 26, true},
    {Signal::kHallAddress1, 21, Pad::kAdB1_11, kAsGpio, pad::kOutput, 0, 0, 1, 27, true},
    {Signal::kHallAddress2, 23, Pad::kAdB1_09, kAsGpio, pad::kOutput, 0, 0, 1, 25, true},
    {Signal::kHallClock, 13, Pad::kB0_03, 3 | kInputOn, pad::kOutputIdleHigh, 0x520, 0, 0, 0, false},  // LPSPI4_SCK
    {Signal::kHallOut, 11, Pad::kB0_02, 3, pad::kOutput, 0x528, 0, 0, 0, false},                       // LPSPI4_SDO
    {Signal::kHallIn, 12, Pad::kB0_01, 3, pad::kInputDown, 0x524, 0, 0, 0, false},                     // LPSPI4_SDI
    {Signal::kCurrentClock, 19, Pad::kAdB1_00, 3 | kInputOn, pad::kBus, 0x4CC, 1, 0, 0, false},        // LPI2C1_SCL
    {Signal::kCurrentData, 18, Pad::kAdB1_01, 3 | kInputOn, pad::kBus, 0x4D0, 1, 0, 0, false},         // LPI2C1_SDA
    {Signal::kFanPwm, 22, Pad::kAdB1_08, 1, pad::kOutput, 0, 0, 0, 0, false},        // FLEXPWM4_PWMA00
    {Signal::kFanTach, 15, Pad::kAdB1_03, 8, pad::kInputUp, 0x764, 1, 0, 0, false},  // GPT2_CAPTURE1
    {Signal::kLed, 24, Pad::kAdB0_12, kAsGpio, pad::kOutput, 0, 0, 1, 12, true},
};

constexpr const Pin& PinOf(Signal signal) noexcept { return kPins[static_cast<int>(signal)]; }

namespace pins_check {
constexpr bool InOrder() {
  for (int i = 0; i < kSignals; ++i) {
    if (static_cast<int>(kPins[i].signal) != i) return false;
  }
  return true;
}
constexpr bool NoneTwice() {
  for (int i = 0; i < kSignals; ++i) {
    for (int k = 0; k < i; ++k) {
      if (kPins[i].pad == kPins[k].pad || kPins[i].teensy == kPins[k].teensy) return false;
      if (kPins[i].port != 0 && kPins[i].port == kPins[k].port && kPins[i].bit == kPins[k].bit) return false;
    }
  }
  return true;
}
static_assert(sizeof kPins / sizeof kPins[0] == kSignals && InOrder(), "one row per signal, in the order of Signal");
static_assert(NoneTwice(), "a pad has one signal");
}  // namespace pins_check

// Outputs first get their resting level (all low; kHallSelectOff high), then their pads: no pin ever drives the wrong
// level.
void SetUpPins() noexcept;

// Of a plain output. A PWM pad follows only after PwmPadsToGround().
void SetPin(Signal signal, bool high) noexcept;

// Takes the PWM pads from FlexPWM2 and drives them low: all bridges brake, whatever the timers do. Irreversible.
void PwmPadsToGround() noexcept;

}  // namespace omni::board
