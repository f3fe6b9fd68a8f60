// A LIS3MDL for tests: its register file, its free-running sample clock and its SPI, without noise; and a faulty bus to
// it. Time passes with the bytes on the bus (4 us each, 2 MHz) and with Wait.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "firmware/drivers/chip_status.h"

namespace omni::support {

class Lis3mdlModel {
 public:
  static constexpr double kByte_us = 4;

  Lis3mdlModel() { PowerCycle(); }

  void set_identity(std::uint8_t identity) { identity_ = identity; }
  void set_field_G(std::array<double, 3> field_G) { field_G_ = field_G; }
  void set_self_test_G(std::array<double, 3> answer_G) { self_test_G_ = answer_G; }
  // Its oscillator is free-running: 1.02 is 2 % fast.
  void set_clock_rate(double rate) { clock_rate_ = rate; }
  void set_reset_time_us(double time_us) { reset_time_us_ = time_us; }
  // It answers and converts no more, until it is reset.
  void Freeze() { frozen_ = true; }
  // Also after a reset.
  void set_frozen_for_good() { frozen_ = frozen_for_good_ = true; }
  long resets() const { return resets_; }
  // From now on control registers ignore writes.
  void set_read_only(bool read_only) { read_only_ = read_only; }
  std::uint8_t reg(int address) const { return registers_.at(static_cast<std::size_t>(address)); }
  long samples() const { return samples_; }

  // The supply fails for a moment: everything is as after power-on, powered down.
  void PowerCycle() {
    registers_.fill(0);
    registers_[0x20] = 0x10;
    registers_[0x22] = 0x03;
    latched_.fill(false);
    reset_left_us_ = 0;
    phase_us_ = 0;
    frozen_ = frozen_for_good_;
  }

  void Wait(double time_us) {
    if (reset_left_us_ > 0) {
      reset_left_us_ -= time_us;
      if (reset_left_us_ <= 0) registers_[0x21] &= static_cast<std::uint8_t>(~0x04);
    }
    if ((registers_[0x22] & 0x03) != 0 || frozen_) return;
    phase_us_ += time_us * clock_rate_;
    for (const double period_us = Period_us(); phase_us_ >= period_us; phase_us_ -= period_us) Sample();
  }

  void Exchange(const std::uint8_t* out, std::uint8_t* in, std::size_t size) {
    burst_began_at_ = samples_;
    Wait(kByte_us);
    in[0] = 0xFF;  // the line is not driven during the address
    const bool read = (out[0] & 0x80) != 0;
    const bool increment = (out[0] & 0x40) != 0;
    int address = out[0] & 0x3F;
    for (std::size_t i = 1; i < size; ++i) {
      Wait(kByte_us);
      in[i] = read ? ReadByte(address) : 0xFF;
      if (!read) WriteByte(address, out[i]);
      if (increment) address = address == 0x2D ? 0x28 : (address + 1) & 0x3F;  // the output wraps around
    }
    latched_.fill(false);
  }

 private:
  double Period_us() const {
    if ((registers_[0x20] & 0x02) != 0) {
      constexpr double kFast_Hz[4] = {1000, 560, 300, 155};
      return 1e6 / kFast_Hz[(registers_[0x20] >> 5) & 3];
    }
    return 1e6 / (0.625 * (1 << ((registers_[0x20] >> 2) & 7)));
  }

  void Sample() {
    ++samples_;
    constexpr double kCounts_G[4] = {6842, 3421, 2281, 1711};
    const double scale = kCounts_G[(registers_[0x21] >> 5) & 3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double field_G = field_G_[axis] + ((registers_[0x20] & 0x01) != 0 ? self_test_G_[axis] : 0);
      Put(axis, field_G * scale);
    }
    const bool overrun = (registers_[0x27] & 0x08) != 0;
    registers_[0x27] = overrun ? 0xFF : 0x0F;
  }

  // Block data update: while one byte of a value has been read, the other is of the same sample.
  void Put(std::size_t word, double counts) {
    if (latched_[word] && (registers_[0x24] & 0x40) != 0) return;
    const auto value = static_cast<std::int16_t>(std::lround(std::fmax(-32768, std::fmin(32767, counts))));
    registers_[0x28 + 2 * word] = static_cast<std::uint8_t>(value & 0xFF);
    registers_[0x29 + 2 * word] = static_cast<std::uint8_t>((value >> 8) & 0xFF);
  }

  std::uint8_t ReadByte(int address) {
    if (address == 0x0F) return identity_;
    const std::uint8_t value = registers_[static_cast<std::size_t>(address)];
    if (address >= 0x28 && address <= 0x2D) latched_[static_cast<std::size_t>((address - 0x28) / 2)] = address % 2 == 0;
    // The sample has been read, unless a new one arrived meanwhile.
    if (address == 0x2D && samples_ == burst_began_at_) registers_[0x27] = 0;
    return value;
  }

  void WriteByte(int address, std::uint8_t value) {
    if (address < 0x20 || address > 0x24 || read_only_) return;
    if (address == 0x21 && (value & 0x04) != 0) {
      PowerCycle();
      ++resets_;
      registers_[0x21] = 0x04;
      reset_left_us_ = reset_time_us_;
      return;
    }
    registers_[static_cast<std::size_t>(address)] = value;
  }

  std::array<std::uint8_t, 64> registers_{};
  std::array<bool, 3> latched_{};
  std::uint8_t identity_ = 0x3D;
  std::array<double, 3> field_G_{};
  std::array<double, 3> self_test_G_{2, 2, 0.5};
  double clock_rate_ = 1;
  double reset_time_us_ = 20;
  double reset_left_us_ = 0;
  double phase_us_ = 0;
  bool read_only_ = false;
  bool frozen_ = false;
  bool frozen_for_good_ = false;
  long resets_ = 0;
  long samples_ = 0;
  long burst_began_at_ = 0;
};

// The bus policy of the driver, with errors if requested.
class FaultySpi {
 public:
  enum class Fault { kNone, kTimeout, kStuckLow, kStuckHigh, kWrongBytes };

  explicit FaultySpi(Lis3mdlModel& chip) : chip_(chip) {}

  drivers::BusStatus Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept {
    ++transfers;
    bytes += static_cast<long>(size);
    if (fault == Fault::kTimeout) return drivers::BusStatus::kTimeout;
    chip_.Exchange(out, in, size);
    for (std::size_t i = 0; i < size; ++i) {
      if (fault == Fault::kStuckLow) in[i] = 0x00;
      if (fault == Fault::kStuckHigh) in[i] = 0xFF;
      if (fault == Fault::kWrongBytes) in[i] ^= 0x10;
    }
    return drivers::BusStatus::kOk;
  }

  Fault fault = Fault::kNone;
  long transfers = 0;
  long bytes = 0;

 private:
  Lis3mdlModel& chip_;
};

}  // namespace omni::support
