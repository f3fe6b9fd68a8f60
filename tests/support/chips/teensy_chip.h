// The i.MX RT1062 as far as the board's code uses it [IMXRT1060RM]: clocks that lock, GPIO, LPSPI4 with eight
// magnetometers behind a 74HC138, LPI2C1 with four current sensors, FlexPWM2 with its fault inputs, timers, watchdog.
// Buses are instantaneous except for the time of their bytes; violations of the manual are counted.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <vector>

#include "tests/support/chips/ina260_model.h"
#include "tests/support/chips/lis3mdl_model.h"
#include "tests/support/chips/teensy_registers.h"

namespace omni::support {

class TeensyChip : public RegisterModel {
 public:
  TeensyChip();
  ~TeensyChip() override { g_register_model = nullptr; }

  std::uint32_t Read(std::uint32_t address, std::uint32_t held) override;
  std::uint32_t Write(std::uint32_t address, std::uint32_t value, std::uint32_t held) override;

  // Time for the chips and the counters.
  void Wait(double time_us);
  std::uint32_t Held(std::uint32_t address) {
    return *static_cast<std::uint32_t*>(RegisterSpace::Get().Place(address));
  }
  std::uint16_t Held16(std::uint32_t address) {
    return *static_cast<std::uint16_t*>(RegisterSpace::Get().Place(address));
  }
  bool Pin(int port, int bit) {
    return (Held(0x42000000U + 0x4000U * static_cast<std::uint32_t>(port - 1)) >> bit & 1) != 0;
  }

  bool I2cInterruptPending();
  // The fan's output falls now.
  void FanEdge();
  // Ticks high of a bridge, as the output pin shows them: 0 while a fault holds it.
  int HighTicks(int bridge);

  Lis3mdlModel halls[8];
  Ina260Model currents[4];
  bool hall_there[8] = {true, true, true, true, true, true, true, true};
  bool current_there[4] = {true, true, true, true};
  bool i2c_line_held = false;
  bool coil_line_low[3] = {};
  bool switch_open = false;
  double now_us = 0;
  long watchdog_feeds = 0;
  long i2c_sessions = 0;

  // Violations of the manual: a job without the master code before it, more than four words in the queue, a transfer
  // with no or a wrong chip selected.
  double spi_us = 0;  // in which bytes were on the bus
  long i2c_without_master_code = 0, i2c_overfilled = 0, spi_unselected = 0;

 private:
  using ReadHook = std::function<std::uint32_t(std::uint32_t)>;
  using WriteHook = std::function<std::uint32_t(std::uint32_t, std::uint32_t)>;
  void Locks(std::uint32_t address);
  void AddAnalog();
  void AddGpio();
  void AddTimers();
  void AddSpi();
  void AddI2c();
  void AddPwm();
  void AddWatchdog();
  void AddUsb();
  int SelectedHall();
  void RunSpi();
  std::uint32_t I2cCommand(std::uint32_t word);
  void I2cAddress(std::uint8_t address);
  void EndI2cWrite();
  std::uint16_t FaultInputs();
  std::uint16_t& Register16(std::uint32_t address) {
    return *static_cast<std::uint16_t*>(RegisterSpace::Get().Place(address));
  }

  std::map<std::uint32_t, ReadHook> reads_;
  std::map<std::uint32_t, WriteHook> writes_;
  std::vector<std::uint8_t> spi_out_;
  std::deque<std::uint8_t> spi_in_;
  std::uint32_t i2c_flags_ = 0;
  std::deque<std::uint8_t> i2c_in_;
  std::vector<std::uint8_t> i2c_out_;
  int i2c_chip_ = -1;
  int i2c_words_ = 0;
  bool i2c_high_speed_ = false, i2c_dead_ = false;
  std::uint16_t pwm_flags_ = 0;
  std::uint32_t cycles_ = 0;
};

}  // namespace omni::support
