// Walks over the neighbours of a triangle: the ring around a vertex, and the angle-weighted pseudonormal of a feature.
#pragma once

#include "service/haptics/geometry/surface.h"

namespace omni::haptics {

inline constexpr int kMaxRing = 512;  // triangles around one vertex that are looked at; a fan beyond is cut off

inline int CornerOf(const Triangle& triangle, std::uint32_t vertex) noexcept {
  if (triangle.vertex[0] == vertex) return 0;
  return triangle.vertex[1] == vertex ? 1 : 2;
}

// Calls visit(triangle index, corner at `vertex`) for every triangle of the fan around `vertex` that holds `start`.
// Returns true if the fan is closed, false if it ends at a border.
template <class Visit>
bool WalkRing(const Surface& surface, std::uint32_t start, std::uint32_t vertex, Visit&& visit) noexcept {
  int left = kMaxRing;
  std::uint32_t current = start;
  do {
    const Triangle& t = surface.GetTriangle(current);
    const int corner = CornerOf(t, vertex);
    visit(current, corner);
    current = t.neighbour[corner];
  } while (current != kNoIndex && current != start && --left > 0);
  if (current != kNoIndex) return true;
  current = surface.GetTriangle(start).neighbour[(CornerOf(surface.GetTriangle(start), vertex) + 2) % 3];
  while (current != kNoIndex && current != start && --left > 0) {
    const Triangle& t = surface.GetTriangle(current);
    const int corner = CornerOf(t, vertex);
    visit(current, corner);
    current = t.neighbour[(corner + 2) % 3];
  }
  return false;
}

// Outward direction at a feature whose sign against (p - closest point) tells outside from inside
// [Baerentzen & Aanaes 2005]: face normal, mean of the two faces of an edge, angle-weighted sum around a vertex. Unit.
Vec3 Pseudonormal(const Surface& surface, std::uint32_t triangle, Feature feature, int index) noexcept;

// True if the feature lies on the border of the mesh.
bool OnBorder(const Surface& surface, std::uint32_t triangle, Feature feature, int index) noexcept;

}  // namespace omni::haptics
