#include "firmware/board/teensy40/chip/pins.h"

#include <initializer_list>

#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

std::uint32_t MuxAddress(const Pin& pin) noexcept { return kIomuxBase + static_cast<std::uint32_t>(pin.pad); }

void Rest(const Pin& pin) noexcept {
  Gpio& gpio = FastGpio(pin.port);
  const std::uint32_t mask = 1U << pin.bit;
  if (pin.signal == Signal::kHallSelectOff) {
    gpio.DR_SET = mask;
  } else {
    gpio.DR_CLEAR = mask;
  }
  gpio.GDIR |= mask;
}

}  // namespace

void SetUpPins() noexcept {
  for (std::uint32_t number = 26; number <= 29; ++number) Gpr(number) = 0xFFFFFFFF;  // all pins on the fast GPIOs
  for (const Pin& pin : kPins) {
    if (pin.output) Rest(pin);
  }
  for (const Pin& pin : kPins) {
    RegisterAt(MuxAddress(pin) + kPadControlOffset) = pin.control;
    if (pin.input_select != 0) RegisterAt(kIomuxBase + pin.input_select) = pin.input_value;
    RegisterAt(MuxAddress(pin)) = pin.function;
  }
}

void SetPin(Signal signal, bool high) noexcept {
  const Pin& pin = PinOf(signal);
  Gpio& gpio = FastGpio(pin.port);
  (high ? gpio.DR_SET : gpio.DR_CLEAR) = 1U << pin.bit;
}

void PwmPadsToGround() noexcept {
  for (const Signal signal : {Signal::kBridgePwm0, Signal::kBridgePwm1, Signal::kBridgePwm2}) {
    SetPin(signal, false);
    RegisterAt(MuxAddress(PinOf(signal))) = kAsGpio;
  }
}

}  // namespace omni::board
