// The eight magnetometers, each with a new sample every millisecond. In every control step four are looked at, the
// other four in the next one, and two of those that have a new sample are read: about 100 us of bus in a step.
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

  // Control step: newest samples, ages, which chips answer. A sample was taken between two looks at its chip: its age
  // is from the middle.
  void Read(std::uint64_t now_us, firmware::Inputs& inputs) noexcept;
  // Control step: the chips' own test field, one chip per step.
  void SelfTest(bool on) noexcept;

  // Main loop: checks the next chip; one that has lost its configuration or never had it is started again. So is, once,
  // one that answers but has no new samples.
  void Maintain() noexcept;

 private:
  // Without a new sample for so long a chip is read all the same, which shows whether it is there at all.
  static constexpr std::uint16_t kSilentSteps = 20;

  struct Channel {
    explicit Channel(std::uint8_t index) noexcept : bus(index), chip(bus) {}
    HallBus bus;
    drivers::Lis3mdl<HallBus> chip;
    drivers::Lis3mdlSample sample;
    std::uint64_t sampled_us = 0;
    std::uint64_t seen_us = 0;  // when the sample that waits was seen
    bool waits = false;
    bool answers = false;
    volatile std::uint16_t quiet_steps = kSilentSteps - 2;  // since its last sample; the main loop reads it
    bool reset = false;                                     // since its last sample
  };

  void Look(std::uint64_t now_us) noexcept;
  void ReadWaiting(int reads, firmware::Inputs& inputs) noexcept;
  bool ReadOne(int index) noexcept;

  Channel channels_[wire::kSensors] = {Channel(0), Channel(1), Channel(2), Channel(3),
                                       Channel(4), Channel(5), Channel(6), Channel(7)};
  bool second_half_ = false;
  int next_read_ = 0;
  int next_test_ = 0;
  int next_check_ = 0;
};

}  // namespace omni::board
