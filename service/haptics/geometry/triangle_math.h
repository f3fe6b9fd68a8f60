// Exact queries on one triangle. Formulas: docs/theory/haptics.md, section 1.
#pragma once

#include <array>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;

using Corners = std::array<Vec3, 3>;

// The part of a triangle a point lies on.
enum class Feature : int { kFace = 0, kEdge = 1, kVertex = 2 };

struct ClosestPoint {
  Vec3 point;
  std::array<double, 3> weights{};  // barycentric, sum 1
  double distance_squared = 0;
  Feature feature = Feature::kFace;
  int index = 0;  // of the edge (vertex k to k + 1) or of the vertex
};

// Nearest point of the triangle to `p`; also for triangles without area.
ClosestPoint ClosestOnTriangle(const Corners& corners, const Vec3& p) noexcept;

struct TriangleHit {
  bool hit = false;
  bool front = false;  // from the front to the back
  double t = 0;        // in [0, 1]: start + t (end - start)
};

// Where the segment crosses the triangle. Watertight: a line through a shared edge or vertex hits at least one of the
// triangles around it.
TriangleHit IntersectTriangle(const Corners& corners, const Vec3& start, const Vec3& end) noexcept;

inline Vec3 AreaVector(const Corners& c) noexcept { return Cross(c[1] - c[0], c[2] - c[0]); }

// Height of `p` over the plane, times the length of `area_vector`; >= 0 counts as in front.
inline double ScaledHeight(const Corners& c, const Vec3& area_vector, const Vec3& p) noexcept {
  return Dot(p - c[0], area_vector);
}

}  // namespace omni::haptics
