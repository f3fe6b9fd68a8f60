// The latched faults that wait for ARM, and the record of the newest, which is kept across a reset.
#pragma once

#include <cstdint>

#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {

// Kept across a reset in memory that start-up does not clear; `check` distinguishes a record from random memory.
struct FaultRecord {
  std::uint32_t fault = 0, faults = 0;
  std::uint8_t state = 0, part = 0;
  std::uint16_t count = 0;  // of faults since the record was cleared
  float value = 0;
  std::uint64_t t_us = 0;
  std::uint32_t check = 0;
};

// CRC-32C of the fields before it, in the order of their declaration.
std::uint32_t CheckOf(const FaultRecord& record) noexcept;

class FaultLatch {
 public:
  // `record`: from before the reset, or random memory.
  explicit FaultLatch(FaultRecord& record) noexcept;

  // True if the fault is new. Faults of the host are latched, but not recorded: they are not failures.
  bool Raise(wire::Fault fault, std::uint8_t part, float value, wire::State state, std::uint64_t t_us) noexcept;
  void Clear(std::uint32_t faults) noexcept { latched_ &= ~faults; }

  std::uint32_t latched() const noexcept { return latched_; }
  bool record_was_broken() const noexcept { return record_was_broken_; }

  // The last fault before the reset; fault 0: none.
  wire::FaultEvent BeforeReset() const noexcept;

 private:
  FaultRecord& record_;
  FaultRecord before_reset_;
  std::uint32_t latched_ = 0;
  bool record_was_broken_ = false;
};

}  // namespace omni::firmware
