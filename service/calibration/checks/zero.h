// Measures again what the sensors read without a pen; the rest of the calibration stays.
#pragma once

#include <array>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::calibration {

// Of one sensor, without the coils' field: means over a quarter of a second each, whole periods of any mains.
inline constexpr int kZeroBlocks = 8;
using ZeroReadings = std::array<base::Vec3, kZeroBlocks>;

// `before` with the new background.
struct Zeroed {
  base::Calibration calibration;
  double uniform_T = 0;  // by which the field around the base has changed
  double own_T = 0;      // the greatest change of one sensor beside it
};

// Rejects, with the reason, what is not a background: readings that move, a field that has changed too much or
// unevenly, as a pen or another magnet does. Precondition: `before` is of the base's own sensors.
base::Result<Zeroed> Rezero(const base::Calibration& before,
                            const std::array<ZeroReadings, base::kSensorCount>& readings);

}  // namespace omni::calibration
