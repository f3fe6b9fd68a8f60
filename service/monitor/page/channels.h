// The numbers that the page gets of every tick: one table, from which follow the binary message, the list in the
// page's first message, its strips and its recordings.
#pragma once

#include <cstddef>
#include <span>

#include "service/protocol/state_memory.h"

namespace omni::monitor {

struct Channel {
  const char* name;   // with its unit: "current_x_A"
  const char* label;  // for people: "current x"
  const char* unit;   // "A"; "" for bits and counts
  const char* group;  // strips that belong together
  float (*value)(const protocol::ToolSample& sample, const protocol::TelemetrySample& telemetry);
};

std::span<const Channel> Channels() noexcept;

// The page gets single precision.
inline float Single(double value) { return static_cast<float>(value); }

}  // namespace omni::monitor
