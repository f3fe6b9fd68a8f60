#include "service/actuation/force_map.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/core_image.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/zonal.h"

namespace omni::actuation {
namespace {

using Eigen::Vector3d;

static_assert(kForceOrders == magnetics::kCoilOrders && kForcePoints == magnetics::kMagnetPoints);

using Points = std::array<Vector3d, kForcePoints>;

Points PlacePoints(const ForceMap& map, const Vector3d& p, const Vector3d& u) noexcept {
  const magnetics::TangentBasis e = magnetics::MakeTangentBasis(u);
  Points points;
  for (std::size_t s = 0; s < points.size(); ++s) {
    const ForcePoint& point = map.points[s];
    points[s] = p + point.ring_1_m * e.e1 + point.ring_2_m * e.e2 + point.axial_m * u;
  }
  return points;
}

// Snapping: every point feels the images of all points, held where they are. docs/theory/actuation.md (5)
Vector3d Snapping(const ForceMap& map, const Points& points, const Vector3d& u) noexcept {
  Vector3d force = Vector3d::Zero();
  for (std::size_t source = 0; source < points.size(); ++source) {
    if (map.points[source].moment_Am2 == 0) continue;
    const magnetics::CoreImage image =
        magnetics::ImageInCore(map.points[source].moment_Am2 * u, points[source], map.core_radius_m, map.core_kappa);
    for (std::size_t s = 0; s < points.size(); ++s) {
      if (map.points[s].moment_Am2 == 0) continue;
      force += map.points[s].moment_Am2 * (magnetics::CoreImageGradient(image, points[s]) * u);
    }
  }
  return force;
}

}  // namespace

ForceMap MakeForceMap(const base::DeviceGeometry& device) {
  ForceMap map;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const auto winding = magnetics::MakeWinding(device.coils[k], static_cast<int>(k));
    const auto coil = magnetics::WindingMoments(winding);
    const auto core = magnetics::CoreMoments(winding, device.core_radius_m, device.core_kappa);
    for (std::size_t j = 0; j < coil.size(); ++j) map.zonal[k][j] = coil[j] + core[j];
    map.axis_base[k] = base::FromEigen(base::ToEigen(device.coils[k].axis_base).normalized());
    map.winding_radius_m = std::max(map.winding_radius_m, device.coils[k].shell_radius_max_m);
  }
  const magnetics::DiscMagnet magnet = magnetics::MakeDiscMagnet(device.magnet);
  for (std::size_t s = 0; s < map.points.size(); ++s) {
    const magnetics::MagnetPoint& point = magnet.points[s];
    map.points[s] = {point.ring_1_m, point.ring_2_m, point.axial_m, point.share * magnet.moment_Am2};
  }
  map.core_radius_m = device.core_radius_m;
  map.core_kappa = device.core_kappa;
  return map;
}

// F = grad (m.B) = G m for a moment m in a curl-free field: column k of X = sum_s m_s G_k(p_s) u.
ForceAtPose EvaluateForceMap(const ForceMap& map, const base::Vec3& position_base_m,
                             const base::Vec3& axis_base) noexcept {
  ForceAtPose result;
  const Vector3d u = base::ToEigen(axis_base);
  const Points points = PlacePoints(map, base::ToEigen(position_base_m), u);
  for (const Vector3d& point : points) {
    if (!(point.norm() > map.winding_radius_m && point.norm() < 1e3)) return result;
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const Vector3d axis = base::ToEigen(map.axis_base[k]);
    Vector3d column = Vector3d::Zero();
    for (std::size_t s = 0; s < points.size(); ++s) {
      if (map.points[s].moment_Am2 == 0) continue;
      column += map.points[s].moment_Am2 * magnetics::ZonalGradientTimes(map.zonal[k], axis, points[s], u);
    }
    for (std::size_t row = 0; row < 3; ++row) result.newton_per_ampere[3 * row + k] = column[static_cast<int>(row)];
  }
  result.snapping_N = base::FromEigen(Snapping(map, points, u));
  result.valid = std::isfinite(result.snapping_N.x + result.snapping_N.y + result.snapping_N.z);
  for (const double entry : result.newton_per_ampere) result.valid = result.valid && std::isfinite(entry);
  return result.valid ? result : ForceAtPose{};
}

}  // namespace omni::actuation
