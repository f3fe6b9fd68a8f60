// Four INA260 on LPI2C1: one per coil and one for the supply. All reads of a control step are one bus session that runs
// by interrupts while the processor reads the magnetometers: master code at 400 kHz, as the chip requires for higher
// rates [TI SBOS656C, 8.5.3.3.1], then repeated starts at 1.5 MHz until the stop. Four reads take about 160 us,
// calculated from the number of bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/drivers/chip_status.h"

namespace omni::board {

// Writes `out`, then, with a repeated start, reads a register's two bytes if asked.
struct I2cJob {
  std::uint8_t address = 0;
  std::uint8_t out[3] = {};
  std::uint8_t out_size = 0;
  bool read = false;
  drivers::BusStatus status = drivers::BusStatus::kTimeout;  // until done
  bool failed = false;
  std::uint8_t in[2] = {};
};

class CurrentBus {
 public:
  static constexpr int kJobsMax = 6;

  void Start() noexcept;

  // Runs `count` jobs, at most kJobsMax; `jobs` stays with the caller and must outlive the session. A running
  // session is aborted: its unfinished jobs keep kTimeout.
  void Begin(I2cJob* jobs, int count) noexcept;
  bool busy() const noexcept { return busy_; }
  void HandleInterrupt() noexcept;

  // firmware/drivers/ina260.h: one job, polled with the interrupt masked, at most
  // kPollBound_us. Never while a session of Begin runs; the interrupt is unmasked afterwards.
  drivers::BusStatus Transfer(std::uint8_t address, const std::uint8_t* out, std::size_t out_size, std::uint8_t* in,
                              std::size_t in_size) noexcept;
  static constexpr std::uint32_t kPollBound_us = 1000;

 private:
  void Launch() noexcept;
  void Push(const I2cJob& job) noexcept;
  void Collect() noexcept;
  void GiveUp() noexcept;
  void Fail(drivers::BusStatus status) noexcept;
  void Finish() noexcept;
  void Advance() noexcept;

  I2cJob* jobs_ = nullptr;
  int count_ = 0;
  int pushed_ = 0;  // jobs given to the controller
  int read_ = 0;    // the job whose bytes come next
  bool stopping_ = false;
  volatile bool busy_ = false;
};

}  // namespace omni::board
