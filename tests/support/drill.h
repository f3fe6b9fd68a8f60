// The same scenario for every build of the core: a base of integers, a host that commands, arms and misbehaves, faults
// that come and go. One checksum covers all outputs, so a host and a micro-controller can compare theirs.
#pragma once

#include <cstdint>

namespace omni::firmware {

// CRC-32C chained over all outputs and frames of `steps` control steps. Only integers and + - * / sqrt of floats.
std::uint32_t DrillChecksum(std::uint32_t steps) noexcept;

// What the scenario has reached, to rule out equal checksums of empty scenarios.
struct DrillTally {
  std::uint32_t crc = 0;
  std::uint32_t armed_steps = 0;
  std::uint32_t frames = 0;
  std::uint32_t faults_seen = 0;  // bits
};
DrillTally DrillWithTally(std::uint32_t steps) noexcept;

}  // namespace omni::firmware
