#include "service/actuation/force_trust.h"

#include <algorithm>
#include <cmath>

namespace omni::actuation {
namespace {

constexpr double kSigmas = 3;

// |X| (Frobenius) with the pen above the base, pointing down.
double ForcePerAmpere(const ForceMap& map, double distance_m) noexcept {
  double square = 0;
  for (const double x : EvaluateForceMap(map, {0, 0, distance_m}, {0, 0, -1}).newton_per_ampere) square += x * x;
  return std::sqrt(square);
}

}  // namespace

double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device, double position_error_m) noexcept {
  if (!(position_error_m >= 0)) return 0;
  const double contact_m = device.hull_radius_m + device.magnet.half_height_m;
  const double seems = ForcePerAmpere(map, contact_m + position_error_m);
  const double is = ForcePerAmpere(map, contact_m);
  const double trust = seems / is;
  return trust >= 0 && trust <= 1 ? trust : 0;
}

double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device) noexcept {
  return ForceTrust(map, device, kDrawnError_m);
}

double ForceTrust(const ForceMap& map, const base::DeviceGeometry& device,
                  const base::Calibration& calibration) noexcept {
  const bool is_stated = calibration.expected_error_m > 0;
  const double error_m = is_stated ? kSigmas * calibration.expected_error_m : kDrawnError_m;
  return ForceTrust(map, device, std::min(error_m, kDrawnError_m));
}

}  // namespace omni::actuation
