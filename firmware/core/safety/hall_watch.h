// Monitors the Hall sensors, each with its own clock: which samples are new, how old, saturated, and whether a sensor
// is dead, stuck or jumps. docs/theory/firmware.md (4.1), (4.2)
#pragma once

#include "firmware/core/board_io.h"
#include "firmware/core/link/settings.h"

namespace omni::firmware {

// Of one step; bit i: sensor i.
struct HallVerdict {
  std::uint8_t fresh = 0;   // a new sample was accepted
  std::uint8_t silent = 0;  // does not answer, or has had no new sample for kHallStale_us
  std::uint8_t stuck = 0;   // has repeated the same sample too often
  std::uint8_t jumps = 0;   // several samples in a row changed more than a magnet can cause
};

class HallWatch {
 public:
  HallVerdict Step(const Settings& settings, const Inputs& inputs) noexcept;

  // Newest accepted sample; a sample that jumps is not accepted until it is a fault.
  const std::int16_t (&field(int sensor) const noexcept)[3] { return field_[sensor]; }
  bool has_sample(int sensor) const noexcept { return has_sample_[sensor]; }
  std::uint64_t sample_us(int sensor) const noexcept { return sample_us_[sensor]; }
  // Bits 3 i + axis, as in TELEMETRY.
  std::uint32_t saturated_mask(const Settings& settings) const noexcept;

 private:
  static constexpr int kCurrentMemory = 8;  // steps: two sample periods

  bool Jumps(const Settings& settings, int sensor, const std::int16_t (&sample)[3]) const noexcept;
  void Handle(const Settings& settings, const Inputs& inputs, int sensor, HallVerdict& verdict) noexcept;
  void WatchCurrents(const Inputs& inputs) noexcept;

  std::int16_t field_[wire::kSensors][3] = {};
  std::uint64_t sample_us_[wire::kSensors] = {};
  std::uint16_t equal_[wire::kSensors] = {};
  std::uint16_t jumped_[wire::kSensors] = {};
  bool has_sample_[wire::kSensors] = {};
  std::int16_t currents_[wire::kCoils][kCurrentMemory] = {};
  int at_ = 0;
  float swing_A_ = 0;  // total change of the coils' currents within that memory
};

}  // namespace omni::firmware
