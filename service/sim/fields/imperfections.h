// How this base and pen differ from their drawing: one draw of base::ImperfectionSizes.
#pragma once

#include <array>

#include "service/base/device_geometry.h"
#include "service/base/truth_parameters.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

using base::ImperfectionSizes;

struct SensorError {
  Vec3 position_base_m;
  Vec3 rotation_rad;  // of the sensor's axes, in its own frame
  Vec3 gain{1, 1, 1};
  Vec3 nonlinearity;  // greatest deviation from the best line over full scale
  Vec3 offset_T, offset_T_K, gain_1_K;
};

struct Imperfections {
  std::array<SensorError, base::kSensorCount> sensors;
  double magnet_strength = 1;
  std::array<double, base::kCoilCount> coil_strength{1, 1, 1};
  std::array<Vec3, base::kCoilCount> coil_rotation_rad;
  std::array<double, base::kCoilCount> current_gain{1, 1, 1};
  std::array<double, base::kCoilCount> current_offset_A{};
  std::array<double, base::kCoilCount> coil_size{1, 1, 1};
  double hull_radius_m = 0;  // more than drawn
  Vec3 core_offset_base_m;
  double core_size = 1;
  double magnet_radius = 1, magnet_height = 1;
  double tip_offset_m = 0;  // more than drawn
};

Imperfections DrawImperfections(const ImperfectionSizes& sizes, Random& random) noexcept;

// The sizes of the base and pen themselves: hull, core, magnet and tip. Strength, and all that has an axis, are not in
// it.
base::DeviceGeometry TrueSizes(const base::DeviceGeometry& device, const Imperfections& imperfections) noexcept;

// All zero: a nominal base.
ImperfectionSizes NoImperfections() noexcept;

// An uncalibrated base: sensors 1 mm per axis, 1.5 % and 1.15 deg wrong, the moment within 2 %.
ImperfectionSizes UncalibratedImperfections() noexcept;

}  // namespace omni::sim
