#include "service/magnetics/disc_magnet.h"

#include <cmath>
#include <numbers>

#include "service/magnetics/dipole.h"

namespace omni::magnetics {
namespace {

constexpr double kUpwards = 0.9999;  // within 0.8 deg of +z

// k3 < 0 (flat): kMagnetPoints dipoles on a ring of rho^2 = -2 k3 / 3.
// k3 > 0 (long): two on the axis at +- sqrt(k3 / 3). k3 = 0: one at the centre.
void PlacePoints(double k3, DiscMagnet& magnet) noexcept {
  if (k3 < 0) {
    const double rho = std::sqrt(-2 * k3 / 3);
    magnet.point_count = kMagnetPoints;
    for (int s = 0; s < kMagnetPoints; ++s) {
      const double angle = 2 * std::numbers::pi * s / kMagnetPoints;
      magnet.points[static_cast<std::size_t>(s)] = {rho * std::cos(angle), rho * std::sin(angle), 0,
                                                    1.0 / kMagnetPoints};
    }
  } else if (k3 > 0) {
    const double height = std::sqrt(k3 / 3);
    magnet.point_count = 2;
    magnet.points[0] = {0, 0, height, 0.5};
    magnet.points[1] = {0, 0, -height, 0.5};
  } else {
    magnet.point_count = 1;
    magnet.points[0] = {0, 0, 0, 1};
  }
}

}  // namespace

// m = Br V / mu0, q3 = m k3, q5 = m k5 with k3 = b^2 - 3 R^2/4, k5 = b^4 - 5/2 R^2 b^2 + 5/8 R^4: the moments of two
// charged discs at +- b.
DiscMagnet MakeDiscMagnet(const base::MagnetGeometry& geometry) noexcept {
  const double R = geometry.radius_m;
  const double volume = geometry.shape == base::MagnetShape::kSphere
                            ? 4 * std::numbers::pi / 3 * R * R * R
                            : std::numbers::pi * R * R * 2 * geometry.half_height_m;
  return MakeDiscMagnet(geometry, geometry.remanence_T * volume / kMu0);
}

DiscMagnet MakeDiscMagnet(const base::MagnetGeometry& geometry, double moment_Am2) noexcept {
  DiscMagnet magnet;
  magnet.moment_Am2 = moment_Am2;
  if (geometry.shape == base::MagnetShape::kSphere) {  // a dipole outside
    magnet.zonal = {moment_Am2, 0, 0};
    PlacePoints(0, magnet);
    return magnet;
  }
  const double R2 = geometry.radius_m * geometry.radius_m;
  const double b2 = geometry.half_height_m * geometry.half_height_m;
  const double k3 = b2 - 0.75 * R2;
  const double k5 = b2 * b2 - 2.5 * R2 * b2 + 0.625 * R2 * R2;
  magnet.zonal = {magnet.moment_Am2, magnet.moment_Am2 * k3, magnet.moment_Am2 * k5};
  PlacePoints(k3, magnet);
  return magnet;
}

TangentBasis MakeTangentBasis(const Eigen::Vector3d& u) noexcept {
  const double sign = u.z() > kUpwards ? 1.0 : -1.0;
  const double a = -1 / (sign + u.z());
  const double b = u.x() * u.y() * a;
  return {{1 + sign * u.x() * u.x() * a, sign * b, -sign * u.x()}, {b, sign + u.y() * u.y() * a, -u.y()}};
}

}  // namespace omni::magnetics
