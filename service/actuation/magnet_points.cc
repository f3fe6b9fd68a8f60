#include "service/actuation/force_map.h"

#include <cmath>
#include <numbers>

#include "service/magnetics/disc_magnet.h"

namespace omni::actuation {
namespace {

// `count` points of a ring about the axis, from points[first] on.
void PutRing(std::size_t first, int count, double radius_m, double share, WeightedPoints& points) {
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    points[first + static_cast<std::size_t>(i)] = {radius_m * std::cos(angle), radius_m * std::sin(angle), 0,
                                                   share / count};
  }
}

// A flat magnet: centre and a ring of seven. A ring with share w at rho has k3 = -3/2 w rho^2, k5 = 15/8 w rho^4.
bool PutFlat(double k3, double k5, WeightedPoints& points) {
  if (!(k3 < 0 && k5 > 0)) return false;
  const double w_rho2 = -2 * k3 / 3;
  const double rho2 = 8 * k5 / 15 / w_rho2;
  const double w = w_rho2 / rho2;
  if (!(w <= 2)) return false;  // k5 nearly 0: a small ring with large shares of both signs
  points[0] = {0, 0, 0, 1 - w};
  PutRing(1, kForcePoints - 1, std::sqrt(rho2), w, points);
  return true;
}

// Any other: ring of five at R sqrt(2/3), a pair at +- b sqrt(3/5) with k3 = 3 w h^2, k5 = 5 w h^4, and the centre.
void PutGeneral(const base::MagnetGeometry& magnet, double k3, double k5, WeightedPoints& points) {
  const double rho2 = magnet.radius_m * magnet.radius_m * 2 / 3;
  const double h2 = magnet.half_height_m * magnet.half_height_m * 3 / 5;
  const double ring_3 = -1.5 * rho2, ring_5 = 1.875 * rho2 * rho2;
  const double pair_3 = 3 * h2, pair_5 = 5 * h2 * h2;
  const double determinant = ring_3 * pair_5 - ring_5 * pair_3;
  const double ring = (k3 * pair_5 - k5 * pair_3) / determinant;
  const double pair = (ring_3 * k5 - ring_5 * k3) / determinant;
  PutRing(0, 5, std::sqrt(rho2), ring, points);
  points[5] = {0, 0, std::sqrt(h2), pair / 2};
  points[6] = {0, 0, -std::sqrt(h2), pair / 2};
  points[7] = {0, 0, 0, 1 - ring - pair};
}

}  // namespace

WeightedPoints MakeMagnetPoints(const base::MagnetGeometry& magnet, MagnetDetail detail) {
  WeightedPoints points{};
  const magnetics::DiscMagnet unit = magnetics::MakeDiscMagnet(magnet, 1.0);  // moments per moment: 1, k3, k5
  if (detail == MagnetDetail::kRing) {
    for (std::size_t i = 0; i < unit.points.size(); ++i) {
      const magnetics::MagnetPoint& point = unit.points[i];
      points[i] = {point.ring_1_m, point.ring_2_m, point.axial_m, point.share};
    }
    return points;
  }
  if (detail == MagnetDetail::kPoint || magnet.shape == base::MagnetShape::kSphere) {
    points[0] = {0, 0, 0, 1};
    return points;
  }
  if (!PutFlat(unit.zonal[1], unit.zonal[2], points)) PutGeneral(magnet, unit.zonal[1], unit.zonal[2], points);
  return points;
}

}  // namespace omni::actuation
