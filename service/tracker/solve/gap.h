// Clearance between the magnet and the hull.
#pragma once

#include "service/base/vec.h"

namespace omni::tracker {

// Distance from the nearest point of a solid cylinder (centre, unit axis, radius, half height) to a sphere of
// `hull_radius_m` about the origin; < 0: the cylinder cuts the sphere. Exact. docs/theory/tracking.md (8.1)
double CylinderGap(const base::Vec3& centre_base_m, const base::Vec3& axis_base, double radius_m, double half_height_m,
                   double hull_radius_m) noexcept;

}  // namespace omni::tracker
