#include "service/actuation/force_map.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::actuation {
namespace {

static_assert(kForceOrders == magnetics::kCoilOrders && kForceCoils == base::kCoilCount);

constexpr double kReach_m = 1e3;         // beyond: not a pose of this device
constexpr double kMomentScaleMax = 100;  // more is no magnet's

struct Core {
  double radius_m;
  double kappa;
};

void PutCoils(const base::DeviceGeometry& device, const Core& core, const ForceModel& model, ForceMap& map) {
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const auto winding = magnetics::MakeWinding(device.coils[k], static_cast<int>(k));
    const auto coil = magnetics::WindingMoments(winding);
    const auto induced = magnetics::CoreMoments(winding, core.radius_m, core.kappa);
    for (std::size_t j = 0; j < coil.size() && static_cast<int>(j) < model.orders; ++j) {
      map.tables.zonal[k][j] = model.scale * (coil[j] + induced[j]);
    }
    const Eigen::Vector3d axis = base::ToEigen(device.coils[k].axis_base).normalized();
    std::copy_n(axis.data(), 3, map.tables.axis_base[k]);
    map.winding_radius_m = std::max(map.winding_radius_m, device.coils[k].shell_radius_max_m);
  }
}

ForceMap Make(const base::DeviceGeometry& device, const base::MagnetGeometry& magnet, double moment_Am2,
              const Core& core, const ForceModel& model) {
  ForceMap map;
  PutCoils(device, core, model, map);
  const WeightedPoints points = MakeMagnetPoints(magnet, model.magnet);
  for (std::size_t s = 0; s < points.size(); ++s) {
    map.tables.ring_1_m[s] = points[s].ring_1_m;
    map.tables.ring_2_m[s] = points[s].ring_2_m;
    map.tables.axial_m[s] = points[s].axial_m;
    map.tables.moment_Am2[s] = points[s].share * moment_Am2;
  }
  map.tables.core_radius_m = core.radius_m;
  map.tables.core_kappa = core.kappa;
  map.kernel = BestForceKernel();
  return map;
}

bool AllFinite(const ForceSums& sums) noexcept {
  // One sum: any NaN or infinity in it, or in a difference of two infinities, shows.
  double all = 0;
  for (int k = 0; k < kForceCoils; ++k) {
    for (int i = 0; i < 3; ++i) all += std::abs(sums.force_N_A[k][i]) + std::abs(sums.torque_Nm_A[k][i]);
  }
  for (int i = 0; i < 3; ++i) all += std::abs(sums.snapping_N[i]) + std::abs(sums.snapping_Nm[i]);
  return std::isfinite(all);
}

}  // namespace

ForceMap MakeForceMap(const base::DeviceGeometry& device, const ForceModel& model) {
  const double moment_Am2 = magnetics::MakeDiscMagnet(device.magnet).moment_Am2;
  return Make(device, device.magnet, moment_Am2, {device.core_radius_m, device.core_kappa}, model);
}

ForceMap MakeForceMap(const base::DeviceGeometry& device, const base::Calibration& calibration,
                      const ForceModel& model) {
  return Make(device, calibration.magnet, calibration.moment_Am2, {calibration.core_radius_m, calibration.core_kappa},
              model);
}

// F = grad (m.B) = G m for a moment m in a curl-free field: column k of X = sum_s m_s G_k(p_s) u.
ForceAtPose EvaluateForceMap(const ForceMap& map, const base::Vec3& position_base_m, const base::Vec3& axis_base,
                             double moment_scale) noexcept {
  ForceAtPose result;
  if (map.kernel == nullptr || !(moment_scale > 0 && moment_scale < kMomentScaleMax)) return result;
  const magnetics::TangentBasis e = magnetics::MakeTangentBasis(base::ToEigen(axis_base));
  const ForcePose pose{.position_m = {position_base_m.x, position_base_m.y, position_base_m.z},
                       .e1 = {e.e1.x(), e.e1.y(), e.e1.z()},
                       .e2 = {e.e2.x(), e.e2.y(), e.e2.z()},
                       .u = {axis_base.x, axis_base.y, axis_base.z}};
  ForceSums sums;
  map.kernel(map.tables, pose, sums);
  for (const double square_m2 : sums.square_radius_m2) {
    if (!(square_m2 > map.winding_radius_m * map.winding_radius_m && square_m2 < kReach_m * kReach_m)) return result;
  }
  if (!AllFinite(sums)) return result;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    for (std::size_t row = 0; row < 3; ++row) {
      result.newton_per_ampere[3 * row + k] = moment_scale * sums.force_N_A[k][row];
      result.newton_metre_per_ampere[3 * row + k] = moment_scale * sums.torque_Nm_A[k][row];
    }
  }
  const double square = moment_scale * moment_scale;
  result.snapping_N = square * base::Vec3{sums.snapping_N[0], sums.snapping_N[1], sums.snapping_N[2]};
  result.snapping_Nm = square * base::Vec3{sums.snapping_Nm[0], sums.snapping_Nm[1], sums.snapping_Nm[2]};
  result.valid = true;
  return result;
}

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
