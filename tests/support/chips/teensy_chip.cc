#include "tests/support/chips/teensy_chip.h"

#include "firmware/board/teensy40/chip/pins.h"

namespace omni::support {
namespace {

constexpr std::uint32_t kGpio = 0x42000000, kSpi = 0x403A0000, kI2c = 0x403F0000, kPwm2 = 0x403E0000, kGpt = 0x401F0000,
                        kPit = 0x40084000, kDog = 0x400BC000, kAnalog = 0x400D8000, kUsb = 0x402E0000;
constexpr std::uint8_t kAddresses[4] = {0x40, 0x41, 0x44, 0x45};
constexpr std::uint32_t kNack = 1U << 10, kPinLow = 1U << 13, kStopSeen = 1U << 9;

}  // namespace

TeensyChip::TeensyChip() {
  RegisterSpace::Get().Clear();
  g_register_model = this;
  AddAnalog();
  AddGpio();
  AddTimers();
  AddSpi();
  AddI2c();
  AddPwm();
  AddWatchdog();
  AddUsb();
}

std::uint32_t TeensyChip::Read(std::uint32_t address, std::uint32_t held) {
  const auto hook = reads_.find(address);
  return hook == reads_.end() ? held : hook->second(held);
}

std::uint32_t TeensyChip::Write(std::uint32_t address, std::uint32_t value, std::uint32_t held) {
  const auto hook = writes_.find(address);
  return hook == writes_.end() ? value : hook->second(value, held);
}

void TeensyChip::Wait(double time_us) {
  now_us += time_us;
  for (Lis3mdlModel& hall : halls) hall.Wait(time_us);
  for (Ina260Model& current : currents) current.Wait(time_us);
  FaultInputs();
}

void TeensyChip::Locks(std::uint32_t address) {
  reads_[address] = [](std::uint32_t held) { return held | 1U << 31; };
}

// Twins: +4 sets, +8 clears. PLLs lock at once, the thermometer has measured 300 counts.
void TeensyChip::AddAnalog() {
  for (std::uint32_t address = kAnalog; address < kAnalog + 0x1A0; address += 16) {
    writes_[address + 4] = [address](std::uint32_t value, std::uint32_t) {
      auto* target = static_cast<std::uint32_t*>(RegisterSpace::Get().Place(address));
      *target |= value;
      return 0U;
    };
    writes_[address + 8] = [address](std::uint32_t value, std::uint32_t) {
      auto* target = static_cast<std::uint32_t*>(RegisterSpace::Get().Place(address));
      *target &= ~value;
      return 0U;
    };
  }
  for (const std::uint32_t pll : {kAnalog, kAnalog + 0x10, kAnalog + 0x30, 0x40080000U}) Locks(pll);
  reads_[kAnalog + 0x180] = [](std::uint32_t held) { return held | 4U | 1300U << 8; };
  reads_[0x401F44E0] = [](std::uint32_t) { return 1500U << 20 | 1200U << 8 | 85U; };
  reads_[0xE0001004] = [this](std::uint32_t) { return cycles_ += 600'000; };
}

void TeensyChip::AddGpio() {
  for (std::uint32_t base = kGpio; base <= kGpio + 0xC000; base += 0x4000) {
    auto* data = static_cast<std::uint32_t*>(RegisterSpace::Get().Place(base));
    writes_[base + 0x84] = [data](std::uint32_t value, std::uint32_t) {
      *data |= value;
      return 0U;
    };
    writes_[base + 0x88] = [data](std::uint32_t value, std::uint32_t) {
      *data &= ~value;
      return 0U;
    };
  }
}

void TeensyChip::AddTimers() {
  writes_[kGpt] = [](std::uint32_t value, std::uint32_t) { return value & ~(1U << 15); };  // its reset ends at once
  writes_[kGpt + 8] = [](std::uint32_t value, std::uint32_t held) { return held & ~value; };
  reads_[kGpt + 0x24] = [this](std::uint32_t) {
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(now_us));
  };
  writes_[kPit + 0x10C] = [](std::uint32_t value, std::uint32_t held) { return held & ~value; };
}

void TeensyChip::FanEdge() {
  *static_cast<std::uint32_t*>(RegisterSpace::Get().Place(kGpt + 0x1C)) =
      static_cast<std::uint32_t>(static_cast<std::uint64_t>(now_us));
  *static_cast<std::uint32_t*>(RegisterSpace::Get().Place(kGpt + 8)) |= 1U << 3;
}

int TeensyChip::SelectedHall() {
  using board::PinOf;
  using board::Signal;
  const auto level = [this](Signal signal) { return Pin(PinOf(signal).port, PinOf(signal).bit); };
  if (level(Signal::kHallSelectOff)) return -1;
  return (level(Signal::kHallAddress0) ? 1 : 0) | (level(Signal::kHallAddress1) ? 2 : 0) |
         (level(Signal::kHallAddress2) ? 4 : 0);
}

void TeensyChip::RunSpi() {
  if (spi_out_.empty()) return;
  std::vector<std::uint8_t> in(spi_out_.size(), 0xFF);
  const int hall = SelectedHall();
  if (hall < 0) {
    ++spi_unselected;
  } else if (hall_there[hall]) {
    halls[hall].Exchange(spi_out_.data(), in.data(), in.size());
  }
  const double time_us = Lis3mdlModel::kByte_us * static_cast<double>(in.size());
  spi_us += time_us;
  now_us += time_us;
  for (int i = 0; i < 8; ++i) {
    if (i != hall || !hall_there[i]) halls[i].Wait(time_us);
  }
  for (Ina260Model& current : currents) current.Wait(time_us);
  spi_in_.insert(spi_in_.end(), in.begin(), in.end());
  spi_out_.clear();
}

void TeensyChip::AddSpi() {
  writes_[kSpi + 0x64] = [this](std::uint32_t value, std::uint32_t) {
    spi_out_.push_back(static_cast<std::uint8_t>(value));
    return 0U;
  };
  reads_[kSpi + 0x70] = [this](std::uint32_t) {
    RunSpi();
    return spi_in_.empty() ? 2U : 0U;
  };
  reads_[kSpi + 0x74] = [this](std::uint32_t) {
    RunSpi();
    if (spi_in_.empty()) return 0U;
    const std::uint32_t byte = spi_in_.front();
    spi_in_.pop_front();
    return byte;
  };
}

void TeensyChip::EndI2cWrite() {
  if (i2c_chip_ >= 0 && !i2c_out_.empty()) currents[i2c_chip_].Write(i2c_out_.data(), i2c_out_.size());
  i2c_out_.clear();
}

void TeensyChip::I2cAddress(std::uint8_t address) {
  EndI2cWrite();
  i2c_chip_ = -1;
  for (int i = 0; i < 4; ++i) {
    if (kAddresses[i] == address >> 1 && current_there[i]) i2c_chip_ = i;
  }
  if (i2c_chip_ < 0) {
    i2c_flags_ |= kNack;
    i2c_dead_ = true;
  }
}

std::uint32_t TeensyChip::I2cCommand(std::uint32_t word) {
  const std::uint32_t command = word >> 8 & 7;
  const auto data = static_cast<std::uint8_t>(word);
  if (++i2c_words_ > 4) ++i2c_overfilled;
  if (i2c_line_held) i2c_flags_ |= kPinLow;
  if (i2c_dead_ || i2c_line_held) return 0;
  switch (command) {
    case 0:
      i2c_out_.push_back(data);
      break;
    case 1: {
      std::uint8_t bytes[2] = {};
      if (i2c_chip_ >= 0) currents[i2c_chip_].Read(bytes, sizeof bytes);
      i2c_in_.insert(i2c_in_.end(), {bytes[0], bytes[1]});
      break;
    }
    case 2:
      EndI2cWrite();
      i2c_high_speed_ = false;
      i2c_flags_ |= kStopSeen;
      break;
    case 5:
      i2c_high_speed_ = data == 0x08;
      ++i2c_sessions;
      break;
    case 6:
      if (!i2c_high_speed_) ++i2c_without_master_code;
      I2cAddress(data);
      break;
    default:
      ++i2c_without_master_code;
  }
  return 0;
}

void TeensyChip::AddI2c() {
  writes_[kI2c + 0x10] = [this](std::uint32_t value, std::uint32_t) {  // MCR
    if ((value & 0x302) == 0) return value;
    i2c_in_.clear();
    i2c_out_.clear();
    i2c_words_ = 0;
    if ((value & 2) != 0) i2c_flags_ = 0;
    return value & ~0x300U;
  };
  reads_[kI2c + 0x14] = [this](std::uint32_t) {  // MSR: what was pushed is sent by now
    i2c_words_ = 0;
    return i2c_flags_ | 1U | (i2c_in_.size() > 1 ? 2U : 0U);
  };
  writes_[kI2c + 0x14] = [this](std::uint32_t value, std::uint32_t) {
    if ((value & kNack) != 0) {
      i2c_dead_ = false;
      i2c_high_speed_ = false;
    }
    i2c_flags_ &= ~value;
    return 0U;
  };
  reads_[kI2c + 0x5C] = [this](std::uint32_t) { return static_cast<std::uint32_t>(i2c_in_.size()) << 16; };
  writes_[kI2c + 0x60] = [this](std::uint32_t value, std::uint32_t) { return I2cCommand(value); };
  reads_[kI2c + 0x70] = [this](std::uint32_t) {
    if (i2c_in_.empty()) return 1U << 14;
    const std::uint32_t byte = i2c_in_.front();
    i2c_in_.pop_front();
    return byte;
  };
}

bool TeensyChip::I2cInterruptPending() {
  const std::uint32_t flags = i2c_flags_ | 1U | (i2c_in_.size() > 1 ? 2U : 0U);
  return (flags & Held(kI2c + 0x18)) != 0;
}

// Bits in which a line says "fault", and those latched.
std::uint16_t TeensyChip::FaultInputs() {
  const std::uint16_t levels = Held16(kPwm2 + 0x18C) >> 12;
  std::uint16_t bad = 0;
  for (int i = 0; i < 3; ++i) {
    const bool high = !coil_line_low[i];
    if (high == ((levels >> i & 1) != 0)) bad = static_cast<std::uint16_t>(bad | 1U << i);
  }
  if (switch_open == ((levels >> 3 & 1) != 0)) bad |= 8;
  pwm_flags_ |= bad;
  return bad;
}

void TeensyChip::AddPwm() {
  reads_[kPwm2 + 0x18E] = [this](std::uint32_t held) {
    const std::uint16_t bad = FaultInputs();
    return (held & 0xF0F0U) | static_cast<std::uint32_t>(bad << 8) | pwm_flags_;
  };
  writes_[kPwm2 + 0x18E] = [this](std::uint32_t value, std::uint32_t) {
    pwm_flags_ = static_cast<std::uint16_t>(pwm_flags_ & ~(value & 0xF));
    FaultInputs();
    return value & 0xF0F0U;
  };
  // CLDOK clears LDOK.
  writes_[kPwm2 + 0x188] = [](std::uint32_t value, std::uint32_t) { return value & ~((value >> 4 & 0xF) | 0xF0U); };
}

int TeensyChip::HighTicks(int bridge) {
  const std::uint32_t base = kPwm2 + 0x60U * static_cast<std::uint32_t>(bridge);
  const bool runs =
      (Held16(kPwm2 + 0x188) >> (8 + bridge) & 1) != 0 && (Held16(kPwm2 + 0x180) >> (8 + bridge) & 1) != 0;
  const std::uint16_t held_by = FaultInputs() | pwm_flags_;
  if (!runs || (Held16(base + 0x2C) & held_by) != 0) return 0;
  return Held16(base + 0x16) - Held16(base + 0x12);
}

void TeensyChip::AddWatchdog() {
  reads_[kDog] = [](std::uint32_t held) { return held | 1U << 10 | 1U << 11; };
  writes_[kDog + 4] = [this](std::uint32_t value, std::uint32_t) {
    if (value == 0xB480A602) ++watchdog_feeds;
    return value;
  };
}

// No host is connected; self-clearing bits are clear.
void TeensyChip::AddUsb() {
  for (const std::uint32_t offset : {0x140U, 0x1B0U, 0x1B4U, 0x1B8U}) {
    reads_[kUsb + offset] = [](std::uint32_t) { return 0U; };
  }
}

}  // namespace omni::support
