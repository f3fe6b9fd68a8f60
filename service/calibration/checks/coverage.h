// Where over the base the pen has been: the upper hemisphere in cells of equal area.
#pragma once

#include <array>

#include "service/base/vec.h"

namespace omni::calibration {

inline constexpr int kCoverageBands = 4;    // by height, the lowest first
inline constexpr int kCoverageSectors = 6;  // by azimuth from +x
inline constexpr int kCoverageCells = kCoverageBands * kCoverageSectors;

struct Coverage {
  std::array<int, kCoverageCells> visits{};  // band * kCoverageSectors + sector

  void Add(const base::Vec3& position_base_m) noexcept;
  double share() const noexcept;  // of cells with a visit
};

}  // namespace omni::calibration
