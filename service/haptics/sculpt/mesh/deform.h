// Moves the vertices of a region; never through a triangle of their own fan. docs/theory/sculpting.md, section 3.
#pragma once

#include "service/haptics/sculpt/mesh/region.h"

namespace omni::haptics::sculpt {

// Longest step (m of offset) in which no edge at the region's triangles changes by more than a quarter of itself, so
// that Displace can judge each triangle before and after.   (3.4)
double LongestStep(const PagedMesh& mesh, const Region& region, const Patch& patch);

// p += offset_m * move. Vertices at which a triangle would lose its area or turn over stay where they are. Returns the
// number of those.
std::size_t Displace(PagedMesh& mesh, const Region& region, const Patch& patch, double offset_m);

}  // namespace omni::haptics::sculpt
