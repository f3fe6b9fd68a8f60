#include "service/tracker/solve/gap.h"

#include <algorithm>
#include <cmath>

namespace omni::tracker {

// The origin in the cylinder's frame is at height -c.u and radius |c - (c.u) u|; the signed distance to a cylinder is
// that to a rectangle in (radius, height)   [Quilez, 2D distance functions: box].
double CylinderGap(const base::Vec3& centre_base_m, const base::Vec3& axis_base, double radius_m, double half_height_m,
                   double hull_radius_m) noexcept {
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
