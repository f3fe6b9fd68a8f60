#include "service/sim/imperfections.h"

namespace omni::sim {

Imperfections DrawImperfections(const ImperfectionSizes& sizes, Random& random) noexcept {
  Imperfections drawn;
  for (SensorError& sensor : drawn.sensors) {
    sensor.position_base_m = random.NormalVector(sizes.sensor_position_m);
    sensor.rotation_rad = random.NormalVector(sizes.sensor_rotation_rad);
    sensor.gain = Vec3{1, 1, 1} + random.NormalVector(sizes.sensor_gain);
  }
  drawn.magnet_strength = 1 + sizes.magnet_moment * random.Normal();
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    drawn.coil_strength[k] = 1 + sizes.coil_strength * random.Normal();
    drawn.coil_rotation_rad[k] = random.NormalVector(sizes.coil_axis_rad);
    drawn.current_gain[k] = 1 + sizes.current_gain * random.Normal();
    drawn.current_offset_A[k] = sizes.current_offset_A * random.Normal();
  }
  for (double& size : drawn.coil_size) size = 1 + sizes.coil_size * random.Normal();
  for (SensorError& sensor : drawn.sensors) sensor.nonlinearity = random.NormalVector(sizes.sensor_nonlinearity);
  return drawn;
}

ImperfectionSizes NoImperfections() noexcept { return {0, 0, 0, 0, 0, 0, 0, 0, 0, 0}; }

ImperfectionSizes UncalibratedImperfections() noexcept {
  ImperfectionSizes sizes;
  sizes.sensor_position_m = 1e-3;
  sizes.sensor_gain = 0.015;
  sizes.sensor_rotation_rad = 0.02007;  // 1.15 deg
  sizes.magnet_moment = 0.02;
  return sizes;
}

}  // namespace omni::sim
