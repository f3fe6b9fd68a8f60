// How far apart two points are, or two unit vectors.
#pragma once

#include <cmath>

#include "service/base/vec.h"

namespace omni::base {

inline double Distance(const Vec3& a, const Vec3& b) noexcept { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

}  // namespace omni::base
