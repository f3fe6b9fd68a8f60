// The chip's own temperature, for telemetry: it warns of a hot enclosure, not of a hot coil [RM TEMPMON].
#pragma once

#include <cstdint>

namespace omni::board {

class Thermometer {
 public:
  void Start() noexcept;
  // 0.01 C; the last finished measurement.
  std::int16_t Read() noexcept;

 private:
  std::int32_t room_count_ = 0, hot_count_ = 0, hot_C_ = 0;
  std::int16_t last_ = 0;
};

}  // namespace omni::board
