// Keeps the triangles of a stroke's region good: long edges are split, short ones collapsed, valences evened out, what
// was changed is smoothed along the surface [Botsch & Kobbelt, A Remeshing Approach to Multiresolution Modeling, SGP
// 2004]. docs/theory/sculpting.md, section 4.
#pragma once

#include "service/haptics/sculpt/mesh/region.h"

namespace omni::haptics::sculpt {

// Longest and shortest edge that are left alone.
struct EdgeRange {
  double long_m = 0;
  double short_m = 0;
};
inline constexpr double kLongEdge = 4.0 / 3;   // of the target
inline constexpr double kShortEdge = 4.0 / 5;  // of the target, or of the region's mean edge if that is less: no
                                               // stroke wipes out finer detail

struct RemeshCounts {
  std::uint32_t splits = 0, collapses = 0, flips = 0, smoothed = 0;
};

// Once over the region and its rim. The region follows: it gets the vertices of splits and loses those of collapses.
// False: nothing was too long or too short, `patch` is still valid; else it is rebuilt.
bool Remesh(PagedMesh& mesh, const EdgeRange& edges, Region& region, Patch& patch, RemeshCounts& counts);

// Splits edges around `at` until, as far as `radius_m` reaches, none is longer than `long_m`. Moves
// nothing; vertices on edges of `region` join it. Returns the triangle that now holds the point.
std::uint32_t RefineBall(PagedMesh& mesh, const SurfacePoint& at, double radius_m, double long_m, Region& region,
                         RemeshCounts& counts);

// After a stroke: takes out what its form does not need, of the vertices that it moved or made. None was further from
// the surface that is left than can be felt (4.4).
void CoarsenStroke(PagedMesh& mesh, double longest_edge_m, Region& region, RemeshCounts& counts);

}  // namespace omni::haptics::sculpt
