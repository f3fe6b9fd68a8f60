#include "service/sim/fields/imperfections.h"

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
  // Drawn only where there are any, so that a seed without them gives the same base as before.
  if (sizes.sensor_offset_T > 0 || sizes.sensor_offset_T_K > 0 || sizes.sensor_gain_1_K > 0) {
    for (SensorError& sensor : drawn.sensors) {
      sensor.offset_T = random.NormalVector(sizes.sensor_offset_T);
      sensor.offset_T_K = random.NormalVector(sizes.sensor_offset_T_K);
      sensor.gain_1_K = random.NormalVector(sizes.sensor_gain_1_K);
    }
  }
  if (sizes.hull_radius_m > 0 || sizes.core_offset_m > 0 || sizes.core_size > 0 || sizes.magnet_size > 0) {
    drawn.hull_radius_m = sizes.hull_radius_m * random.Normal();
    drawn.core_offset_base_m = random.NormalVector(sizes.core_offset_m);
    drawn.core_size = 1 + sizes.core_size * random.Normal();
    drawn.magnet_radius = 1 + sizes.magnet_size * random.Normal();
    drawn.magnet_height = 1 + sizes.magnet_size * random.Normal();
  }
  if (sizes.tip_offset_m > 0) drawn.tip_offset_m = sizes.tip_offset_m * random.Normal();
  return drawn;
}

// Keeps the nominal moment: remanence times volume.
base::DeviceGeometry TrueSizes(const base::DeviceGeometry& device, const Imperfections& imperfections) noexcept {
  base::DeviceGeometry made = device;
  made.hull_radius_m += imperfections.hull_radius_m;
  made.core_radius_m *= imperfections.core_size;
  made.magnet.radius_m *= imperfections.magnet_radius;
  made.magnet.half_height_m *= imperfections.magnet_height;
  made.magnet.tip_offset_m += imperfections.tip_offset_m;
  made.magnet.remanence_T /= imperfections.magnet_radius * imperfections.magnet_radius * imperfections.magnet_height;
  return made;
}

ImperfectionSizes NoImperfections() noexcept { return {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}; }

ImperfectionSizes UncalibratedImperfections() noexcept {
  ImperfectionSizes sizes;
  sizes.sensor_position_m = 1e-3;
  sizes.sensor_gain = 0.015;
  sizes.sensor_rotation_rad = 0.02007;  // 1.15 deg
  sizes.magnet_moment = 0.02;
  return sizes;
}

}  // namespace omni::sim
