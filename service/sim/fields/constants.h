#pragma once

#include <numbers>

namespace omni::sim {

inline constexpr double kMu0 = 4e-7 * std::numbers::pi;  // permeability of vacuum, T m/A
inline constexpr double kMu0Over4Pi = 1e-7;

}  // namespace omni::sim
