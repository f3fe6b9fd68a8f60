// How this base and pen differ from their drawing. Defaults are what remains after a good calibration: the service of
// today knows only the nominal geometry, and these errors cost it .3-.5 mm of tracking.
#pragma once

#include <array>

#include "service/base/device_geometry.h"
#include "service/sim/random.h"
#include "service/sim/vec3.h"

namespace omni::sim {

// Standard deviations of independent normal errors.
struct ImperfectionSizes {
  double sensor_position_m = 0.05e-3;  // per axis
  double sensor_gain = 1e-3;           // per axis
  double sensor_rotation_rad = 1.75e-3;
  double magnet_moment = 2e-3;
  double coil_strength = 1e-3;
  double coil_axis_rad = 1e-3;
  double current_gain = 1.5e-3;  // INA260: 0.15 %
  double current_offset_A = 2e-3;
};

struct SensorError {
  Vec3 position_base_m;
  Vec3 rotation_rad;  // of the sensor's axes, in its own frame
  Vec3 gain{1, 1, 1};
};

struct Imperfections {
  std::array<SensorError, base::kSensorCount> sensors;
  double magnet_strength = 1;
  std::array<double, base::kCoilCount> coil_strength{1, 1, 1};
  std::array<Vec3, base::kCoilCount> coil_rotation_rad;
  std::array<double, base::kCoilCount> current_gain{1, 1, 1};
  std::array<double, base::kCoilCount> current_offset_A{};
};

Imperfections DrawImperfections(const ImperfectionSizes& sizes, Random& random) noexcept;

}  // namespace omni::sim
