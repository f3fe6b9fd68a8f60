// Capacities that several modules share. Each has a name and a defined behaviour when full.
#pragma once

namespace omni::base {

inline constexpr int kSensorCount = 8;   // Hall sensors of the base, three axes each
inline constexpr int kCoilCount = 3;     // coils x, y, z
inline constexpr int kStepsPerTick = 4;  // control steps of the base
inline constexpr double kTickPeriod_s = 1e-3;
inline constexpr long long kTickPeriod_ns = 1'000'000;

}  // namespace omni::base
