// The walls a car meets: where the plane it drives on cuts the objects marked as car walls. Ground below the plane is
// not cut and does not count.
#pragma once

#include "service/haptics/geometry/surface.h"

namespace omni::haptics {

struct Wall {
  bool found = false;
  double distance_m = 0;  // of the car's centre
  Vec3 normal;            // horizontal, unit, from the wall to the car
  std::uint32_t material = 0;
};

// Nearest wall to `p`, in the plane z = p.z, that is nearer than `reach_m`.
Wall NearestWall(const Scene& scene, const Surface& surface, const Vec3& p, double reach_m) noexcept;

}  // namespace omni::haptics
