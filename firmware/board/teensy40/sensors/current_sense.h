// The currents of the coils and the voltage of the supply, once per control step, from four INA260.
//
// A coil's chip sits between its bridge's output A and the coil and reads current only: new every 140 us, signed. Its
// alert acts on one sign at a time, so the side follows the current. The coil's voltage is not read from that chip:
// with the direction reversed its pin sees no voltage, and 140 us is 2.8 PWM periods, not a whole number. It is
// computed as the duty times the supply, which the fourth chip measures.
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/sensors/current_bus.h"
#include "firmware/core/board_io.h"
#include "firmware/drivers/ina260.h"

namespace omni::board {

class CurrentSense {
 public:
  static constexpr int kChips = wire::kCoils + 1;
  static constexpr int kSupply = wire::kCoils;
  // Address pins A1 A0: ground ground, ground supply, supply ground, supply supply [TI SBOS656C, table 3].
  static constexpr std::uint8_t kAddress[kChips] = {0x40, 0x41, 0x44, 0x45};

  explicit CurrentSense(float alert_A) noexcept;

  // Starts bus and chips; Maintain retries chips that do not answer. Interrupts may be off.
  void Start() noexcept;

  // The results since RequestReadings: currents, supply, which chips answer.
  void CollectReadings(firmware::Inputs& inputs) noexcept;
  // Starts the reads for the next Collect, and at most one more transfer: an alert's side, the release of a latched
  // alert (`lines_low`: coils whose fault line is low; only while `nothing_driven`), or a check of a chip's
  // configuration.
  void RequestReadings(std::uint8_t lines_low, bool nothing_driven) noexcept;

  // Main loop, only while all bridges sleep: starts a chip that is not running, one per call. Meanwhile Collect repeats
  // its values, for at most 20 ms.
  void Maintain() noexcept;

  void HandleInterrupt() noexcept { bus_.HandleInterrupt(); }

 private:
  using Chip = drivers::Ina260<CurrentBus>;
  bool AlertJob(I2cJob& job) noexcept;
  bool ReleaseJob(std::uint8_t lines_low, I2cJob& job) noexcept;
  bool CheckJob(I2cJob& job) noexcept;
  void TakeCurrent(int coil) noexcept;
  bool running(int chip) const noexcept { return chips_[chip].started() && !lost_[chip]; }

  struct Alert {
    bool negative = false;
    std::uint8_t stage = 0;  // writes left
  };

  CurrentBus bus_;
  Chip chips_[kChips];
  bool lost_[kChips] = {};
  std::int16_t limit_counts_;
  I2cJob jobs_[CurrentBus::kJobsMax];
  int job_count_ = 0;
  Alert alerts_[wire::kCoils];
  std::int16_t current_[wire::kCoils] = {};
  std::uint16_t supply_ = 0;
  std::uint8_t supply_missed_ = 0;
  std::uint8_t answers_ = 0;
  std::uint32_t step_ = 0;
  int checking_ = -1;  // chip whose configuration is the last job
  int next_start_ = 0;
  volatile bool paused_ = false;
};

}  // namespace omni::board
