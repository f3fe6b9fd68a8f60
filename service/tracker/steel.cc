#include "service/tracker/steel.h"

namespace omni::tracker {

// With M the mirror, the base's own field B at the images s', 0' of sensor and core's centre, n = s / |s| and g the
// gain of the core's image at s:
//   B_steel(s) = strength (-M B(s') + g (3 (n.U) n - U)),   U = -M B(0')
LocalField SteelField(const Model& model, const Pose& pose, double moment_scale) noexcept {
  const SteelMirror& steel = model.steel;
  const double scale = steel.strength * moment_scale;
  const KernelPose at = ToKernel(MakePosePoint(pose), {}, {});
  const double mirror[3] = {-scale, -scale, scale};
  BlockField mirrored, centre;
  ActiveKernel().field(steel.sensors, model.tool, at, mirrored);
  if (model.tool.core) ActiveKernel().field(steel.centre, model.tool, at, centre);
  LocalField field_T;
  const SensorPlaces<double>& places = model.places[0];
  for (std::size_t i = 0; i < kSensors; ++i) {
    for (std::size_t c = 0; c < 3; ++c) field_T[c][i] = mirror[c] * mirrored.B_T[c][i];
    if (!model.tool.core) continue;
    double along = 0;
    for (std::size_t c = 0; c < 3; ++c) along += places.radial_base[c][i] * mirror[c] * centre.B_T[c][i];
    for (std::size_t c = 0; c < 3; ++c) {
      field_T[c][i] +=
          places.image_field_gain[i] * (3 * along * places.radial_base[c][i] - mirror[c] * centre.B_T[c][i]);
    }
  }
  return field_T;
}

}  // namespace omni::tracker
