// What clocks the loop: telemetry arrival, an absolute timer, or virtual time. Loop declares it, others implement it.
#pragma once

#include <cstdint>

#include "service/base/actuation_types.h"
#include "service/base/hall_scan.h"

namespace omni::loop {

enum class WaitStatus : std::uint8_t { kTick = 0, kTimeout = 1, kGone = 2, kEnd = 3 };

class TickSource {
 public:
  virtual ~TickSource() = default;
  // Waits for the next tick and fills its scan. kTimeout: no telemetry within the source's own patience.
  virtual WaitStatus Wait(base::HallScan& scan) noexcept = 0;
  virtual void Apply(const base::CoilCurrents& currents) noexcept = 0;
};

}  // namespace omni::loop
