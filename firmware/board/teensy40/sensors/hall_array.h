// The eight magnetometers: read in every control step (about 90 us), each delivers a new sample every millisecond.
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/sensors/hall_bus.h"
#include "firmware/core/board_io.h"
#include "firmware/drivers/lis3mdl.h"

namespace omni::board {

class HallArray {
 public:
  // Starts bus and chips; Maintain retries chips that do not answer.
  void Start() noexcept;

  // Control step: newest samples, ages, which chips answer.
  void Read(std::uint64_t now_us, firmware::Inputs& inputs) noexcept;
  // Control step: the chips' own test field, one chip per step.
  void SelfTest(bool on) noexcept;

  // Main loop: checks the next chip; one that has lost its configuration or never had it is started again.
  void Maintain() noexcept;

 private:
  struct Channel {
    explicit Channel(std::uint8_t index) noexcept : bus(index), chip(bus) {}
    HallBus bus;
    drivers::Lis3mdl<HallBus> chip;
    drivers::Lis3mdlSample sample;
    std::uint64_t sampled_us = 0;
  };

  void ReadOne(int index, std::uint64_t now_us, firmware::Inputs& inputs) noexcept;

  Channel channels_[wire::kSensors] = {Channel(0), Channel(1), Channel(2), Channel(3),
                                       Channel(4), Channel(5), Channel(6), Channel(7)};
  int next_test_ = 0;
  int next_check_ = 0;
};

}  // namespace omni::board
