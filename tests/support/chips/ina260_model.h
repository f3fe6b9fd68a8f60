// An INA260 for tests: registers, pointer, conversions in turn and the alert pin; and an I2C bus with faults and
// several of them. Time passes with the bytes on the bus (9 us each, 1 MHz) and with Wait.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>

#include "firmware/drivers/chip_status.h"

namespace omni::support {

class Ina260Model {
 public:
  Ina260Model() { PowerCycle(); }

  void set_current_A(double current_A) { current_A_ = current_A; }
  void set_voltage_V(double voltage_V) { voltage_V_ = voltage_V; }
  void set_identity(std::uint16_t manufacturer, std::uint16_t die) {
    manufacturer_ = manufacturer;
    die_ = die;
  }
  void set_read_only(bool read_only) { read_only_ = read_only; }
  std::uint16_t reg(std::uint8_t number) const { return registers_.count(number) != 0 ? registers_.at(number) : 0; }
  bool alert_is_low() const { return (reg(0x06) & 0x0010) != 0; }
  long conversions() const { return conversions_; }

  void PowerCycle() {
    registers_ = {{0x00, 0x6127}, {0x01, 0}, {0x02, 0}, {0x03, 0}, {0x06, 0}, {0x07, 0}};
    pointer_ = 0;
    phase_us_ = 0;
    voltage_is_next_ = false;
  }

  void Wait(double time_us) {
    if ((reg(0x00) & 0x4) == 0) return;  // shut down or triggered: no conversions here
    phase_us_ += time_us;
    while (phase_us_ >= Conversion_us()) {
      phase_us_ -= Conversion_us();
      Convert();
    }
  }

  void Write(const std::uint8_t* bytes, std::size_t size) {
    if (size >= 1) pointer_ = bytes[0];
    if (size != 3) return;
    const auto value = static_cast<std::uint16_t>((bytes[1] << 8) | bytes[2]);
    if (read_only_ || (pointer_ != 0x00 && pointer_ != 0x06 && pointer_ != 0x07)) return;
    if (pointer_ == 0x00 && (value & 0x8000) != 0) {
      PowerCycle();
    } else if (pointer_ == 0x06) {
      registers_[0x06] = static_cast<std::uint16_t>((value & 0xFC03) | (reg(0x06) & 0x0010));
    } else {
      registers_[pointer_] = pointer_ == 0x00 ? static_cast<std::uint16_t>((value & 0x0FFF) | 0x6000) : value;
    }
  }

  void Read(std::uint8_t* bytes, std::size_t size) {
    const std::uint16_t value = pointer_ == 0xFE ? manufacturer_ : pointer_ == 0xFF ? die_ : reg(pointer_);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i % 2 == 0 ? value >> 8 : value & 0xFF);
    if (pointer_ == 0x06) registers_[0x06] &= static_cast<std::uint16_t>(~0x0018);
  }

 private:
  double Conversion_us() const {
    constexpr double kTimes_us[8] = {140, 204, 332, 588, 1100, 2116, 4156, 8244};
    constexpr int kAverages[8] = {1, 4, 16, 64, 128, 256, 512, 1024};
    const std::uint16_t config = reg(0x00);
    return kTimes_us[(config >> (voltage_is_next_ ? 6 : 3)) & 7] * kAverages[(config >> 9) & 7];
  }

  void Convert() {
    ++conversions_;
    const bool voltage = voltage_is_next_;
    const bool both = (reg(0x00) & 0x3) == 0x3;
    voltage_is_next_ = both && !voltage;
    if (voltage) {
      registers_[0x02] = static_cast<std::uint16_t>(std::lround(std::fmax(0, voltage_V_) / 1.25e-3));
      return;
    }
    const auto counts =
        static_cast<std::int16_t>(std::lround(std::fmax(-32768, std::fmin(32767, current_A_ / 1.25e-3))));
    registers_[0x01] = static_cast<std::uint16_t>(counts);
    const auto limit = static_cast<std::int16_t>(reg(0x07));
    const bool over = (reg(0x06) & 0x8000) != 0 && counts > limit;
    const bool under = (reg(0x06) & 0xC000) == 0x4000 && counts < limit;
    if (over || under) {
      registers_[0x06] |= 0x0010;
    } else if ((reg(0x06) & 0x0001) == 0) {
      registers_[0x06] &= static_cast<std::uint16_t>(~0x0010);
    }
  }

  std::map<std::uint8_t, std::uint16_t> registers_;
  std::uint8_t pointer_ = 0;
  std::uint16_t manufacturer_ = 0x5449;
  std::uint16_t die_ = 0x2270;
  double current_A_ = 0;
  double voltage_V_ = 0;
  double phase_us_ = 0;
  bool voltage_is_next_ = false;
  bool read_only_ = false;
  long conversions_ = 0;
};

// The bus policy of the driver.
class FaultyI2c {
 public:
  enum class Fault { kNone, kNack, kStuck, kWrongBytes };

  void Attach(std::uint8_t address, Ina260Model& chip) { chips_[address] = &chip; }

  void Wait(double time_us) {
    for (const auto& [address, chip] : chips_) chip->Wait(time_us);
  }

  drivers::BusStatus Transfer(std::uint8_t address, const std::uint8_t* out, std::size_t out_size, std::uint8_t* in,
                              std::size_t in_size) noexcept {
    // Start, address and its acknowledge for each direction.
    const std::size_t count = out_size + in_size + (out_size != 0 ? 1 : 0) + (in_size != 0 ? 1 : 0);
    bytes += static_cast<long>(count);
    Wait(9.0 * static_cast<double>(count));
    if (fault_in == 0) fault = fault_then;
    if (fault_in >= 0) --fault_in;
    if (fault == Fault::kStuck) return drivers::BusStatus::kTimeout;
    if (fault == Fault::kNack || chips_.count(address) == 0) return drivers::BusStatus::kNack;
    Ina260Model& chip = *chips_[address];
    if (out_size != 0) chip.Write(out, out_size);
    if (in_size != 0) chip.Read(in, in_size);
    if (fault == Fault::kWrongBytes) {
      for (std::size_t i = 0; i < in_size; ++i) in[i] ^= 0x01;
    }
    return drivers::BusStatus::kOk;
  }

  Fault fault = Fault::kNone;
  // After so many more transfers the fault becomes `fault_then`; -1: never.
  int fault_in = -1;
  Fault fault_then = Fault::kNone;
  long bytes = 0;

 private:
  std::map<std::uint8_t, Ina260Model*> chips_;
};

}  // namespace omni::support
