// Distances along the surface from a point on it. docs/theory/sculpting.md, section 2.
#pragma once

#include "service/haptics/sculpt/mesh/paged_mesh.h"

namespace omni::haptics::sculpt {

struct SurfacePoint {
  std::uint32_t triangle = kNoIndex;
  Vec3 position;
};

struct GeodesicVertex {
  std::uint32_t vertex;
  double distance_m;
};

// All vertices nearer than `radius_m` along the surface, nearest first; at most `most`, then the result is longer by
// one. Exact while the surface between is flat and its triangles are not obtuse; elsewhere a little too long.
std::vector<GeodesicVertex> GeodesicBall(const PagedMesh& mesh, const SurfacePoint& from, double radius_m,
                                         std::size_t most);

}  // namespace omni::haptics::sculpt
