// Results of accessing a chip. A driver reads and writes through a bus policy, so that the same code runs on the
// micro-controller's bus and, in tests, on a register model. No driver waits without a time limit.
#pragma once

#include <cstdint>

namespace omni::drivers {

// Result of a bus policy's transfer.
enum class BusStatus : std::uint8_t {
  kOk = 0,
  kNack,     // I2C: the chip did not acknowledge its address or a byte
  kTimeout,  // the bus is held, or its controller never finished
};

// Result of a driver's call. Only kOk fills outputs, unless stated otherwise.
enum class ChipStatus : std::uint8_t {
  kOk = 0,
  kNoNewSample,    // no error, the chip has no new measurement
  kNack,           // as BusStatus
  kTimeout,        // as BusStatus
  kNoAnswer,       // only zeros or only ones: no chip, no supply, or a stuck line
  kWrongIdentity,  // another chip, or garbled bytes
  kNotTaken,       // a register did not accept what was written
  kChanged,        // the chip had lost its configuration (brown-out) and has been configured again
  kNotStarted,     // Start has not succeeded yet
};

constexpr ChipStatus ToChipStatus(BusStatus status) noexcept {
  return status == BusStatus::kOk     ? ChipStatus::kOk
         : status == BusStatus::kNack ? ChipStatus::kNack
                                      : ChipStatus::kTimeout;
}

// Wrap around; for telemetry and for the bring-up of a board.
struct ChipCounters {
  std::uint32_t bus_errors = 0;      // kNack, kTimeout, kNoAnswer
  std::uint32_t wrong_identity = 0;  // kWrongIdentity
  std::uint32_t changed = 0;         // kChanged, kNotTaken
};

}  // namespace omni::drivers
