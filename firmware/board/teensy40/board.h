// The base on a Teensy 4.0: fills the core's inputs, applies its outputs, carries its frames. One control interrupt at
// 4 kHz does all of it; the main loop only reconfigures chips that have lost their configuration.
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/bridges.h"
#include "firmware/board/teensy40/chip/chip.h"
#include "firmware/board/teensy40/sensors/current_sense.h"
#include "firmware/board/teensy40/sensors/hall_array.h"
#include "firmware/board/teensy40/timebase.h"
#include "firmware/board/teensy40/usb_port.h"
#include "firmware/core/board_io.h"
#include "firmware/drivers/fan_tach.h"
#include "firmware/drivers/g2_driver.h"

namespace omni::board {

class Board {
 public:
  explicit Board(const firmware::Settings& settings) noexcept;

  // Interrupts are off. Bridges sleep, chips are started, then time and USB run.
  void Start() noexcept;

  // firmware/core/run.h: the control step.
  void Read(firmware::Inputs& inputs) noexcept;
  void Write(const firmware::Outputs& outputs) noexcept;
  std::size_t Receive(std::uint8_t* frame, std::size_t capacity) noexcept { return usb_.Receive(frame, capacity); }
  bool Send(const std::uint8_t* frame, std::size_t size) noexcept { return usb_.Send(frame, size); }

  void UsbInterrupt() noexcept { usb_.HandleInterrupt(); }
  void CurrentBusInterrupt() noexcept { currents_.HandleInterrupt(); }

  // Called by the main loop, after every interrupt.
  void Maintain() noexcept;

 private:
  using Bridge = drivers::G2Driver<Bridges::Pins>;
  bool AllAsleep() const noexcept;
  void ReadFaults(firmware::Inputs& inputs) noexcept;
  void ReadVoltages(firmware::Inputs& inputs) noexcept;

  Timebase time_;
  Bridges bridges_;
  Bridges::Pins pins_[kBridges] = {{bridges_, 0}, {bridges_, 1}, {bridges_, 2}};
  Bridge drivers_[kBridges] = {Bridge(pins_[0]), Bridge(pins_[1]), Bridge(pins_[2])};
  HallArray halls_;
  CurrentSense currents_;
  Thermometer thermometer_;
  Timebase::FanCapture capture_;
  drivers::FanTach<Timebase::FanCapture> tach_{capture_};
  FanPwm fan_;
  UsbPort usb_;
  std::int16_t duty_[kBridges] = {};  // of the step before
  std::int16_t temperature_ = 0;
  volatile std::uint32_t steps_ = 0;
  std::uint32_t maintained_ = 0;
  volatile bool all_asleep_ = true;
};

}  // namespace omni::board
