// The latched faults that wait for ARM, and the record of the newest, which is kept across a reset.
#pragma once

#include <cstdint>

#include "firmware/core/safety/fault_record.h"
#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {

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
