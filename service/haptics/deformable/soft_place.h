#pragma once

#include <cstdint>

namespace omni::haptics {

inline constexpr std::uint32_t kNoSoftTriangle = 0xFFFFFFFF;

// A place on the coarse surface of a soft body.
struct SoftPlace {
  std::uint32_t triangle = kNoSoftTriangle;
  double weights[3]{};  // barycentric, >= 0, sum 1
};

}  // namespace omni::haptics
