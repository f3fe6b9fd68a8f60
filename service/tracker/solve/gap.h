// Clearance between the magnet and the hull.
#pragma once

#include <algorithm>
#include <cmath>

#include "service/base/vec.h"

namespace omni::tracker {

// Distance from the nearest point of a solid cylinder (centre, unit axis, radius, half height) to a sphere of
// `hull_radius_m` about the origin; < 0: the cylinder cuts the sphere. Exact. docs/theory/tracking.md (8.1)
//
// The origin in the cylinder's frame is at height -c.u and radius |c - (c.u) u|; the signed distance to a cylinder is
// that to a rectangle in (radius, height)   [Quilez, 2D distance functions: box].
inline double CylinderGap(const base::Vec3& centre_base_m, const base::Vec3& axis_base, double radius_m,
                          double half_height_m, double hull_radius_m) noexcept {
  const base::Vec3& c = centre_base_m;
  const base::Vec3& u = axis_base;
  const double height = Dot(c, u);
  const double x = c.x - height * u.x, y = c.y - height * u.y, z = c.z - height * u.z;
  const double beyond_side = std::sqrt(x * x + y * y + z * z) - radius_m;
  const double beyond_face = std::abs(height) - half_height_m;
  const double outside = std::hypot(std::max(beyond_side, 0.0), std::max(beyond_face, 0.0));
  const double inside = std::min(std::max(beyond_side, beyond_face), 0.0);
  return outside + inside - hull_radius_m;
}

}  // namespace omni::tracker
