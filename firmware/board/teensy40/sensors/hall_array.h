// The eight magnetometers, each with a new sample every millisecond. In every control step four are looked at, the
// other four in the next one, and two of those that have a new sample are read: about 100 us of bus in a step.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/core/board_io.h"
#include "firmware/drivers/chip_status.h"
#include "firmware/drivers/lis3mdl.h"

namespace omni::board {

// Eight magnetometers on LPSPI4: mode 3, 1.94 MHz, chip selects by a 74HC138. The chip takes 10 MHz, but carrier boards
// with level shifters (a FET and a pull-up on SCL and SDA, as Pololu's) have edges of 100 ns.
#ifndef OMNI_HALL_SPI_DIVIDER  // the bring-up compares clocks: firmware/README.md
#define OMNI_HALL_SPI_DIVIDER 34
#endif
constexpr std::uint32_t kSpiDivider = OMNI_HALL_SPI_DIVIDER;
static_assert(kSpiSource_Hz / kSpiDivider <= 2'000'000, "slow enough for level shifters; the LIS3MDL takes 10 MHz");

void StartHallBus() noexcept;

// firmware/drivers/lis3mdl.h. A transfer is one section without interrupts, at most 40 us: the control interrupt reads
// the sensors while the main loop may be configuring one.
class HallBus {
 public:
  explicit HallBus(std::uint8_t index) noexcept : index_(index) {}
  drivers::BusStatus Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept;

 private:
  std::uint8_t index_;  // 0 to 7
};

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
