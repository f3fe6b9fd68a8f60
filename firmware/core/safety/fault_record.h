// Kept across a reset in memory that start-up does not clear; `check` distinguishes a record from random memory.
#pragma once

#include <cstdint>

namespace omni::firmware {

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

}  // namespace omni::firmware
