// Walks over the neighbours of a triangle: the ring around a vertex, and the angle-weighted pseudonormal of a feature.
#pragma once

#include "service/haptics/geometry/surface.h"

namespace omni::haptics {

inline constexpr int kMaxRing = 512;  // triangles around one vertex that are visited; a longer fan is cut off

template <class Triangle>
int CornerOf(const Triangle& triangle, std::uint32_t vertex) noexcept {
  if (triangle.vertex[0] == vertex) return 0;
  return triangle.vertex[1] == vertex ? 1 : 2;
}

// Calls visit(triangle index, corner at `vertex`) for every triangle of the fan around `vertex` that holds `start`.
// Returns true if the fan is closed, false if it ends at a border.
template <MeshView View, class Visit>
bool WalkRing(const View& view, std::uint32_t start, std::uint32_t vertex, Visit&& visit) noexcept {
  int left = kMaxRing;
  std::uint32_t current = start;
  do {
    const auto& t = view.GetTriangle(current);
    const int corner = CornerOf(t, vertex);
    visit(current, corner);
    current = t.neighbour[corner];
  } while (current != kNoIndex && current != start && --left > 0);
  if (current != kNoIndex) return true;
  current = view.GetTriangle(start).neighbour[(CornerOf(view.GetTriangle(start), vertex) + 2) % 3];
  while (current != kNoIndex && current != start && --left > 0) {
    const auto& t = view.GetTriangle(current);
    const int corner = CornerOf(t, vertex);
    visit(current, corner);
    current = t.neighbour[(corner + 2) % 3];
  }
  return false;
}

template <MeshView View>
Vec3 FaceNormal(const View& view, std::uint32_t triangle) noexcept {
  return Normalized(AreaVector(view.TriangleCorners(triangle)));
}

// Outward direction at a feature whose sign against (p - closest point) distinguishes outside from inside
// [Baerentzen & Aanaes 2005]: face normal, mean of the two faces of an edge, angle-weighted sum around a vertex. Unit.
template <MeshView View>
Vec3 Pseudonormal(const View& view, std::uint32_t triangle, Feature feature, int index) noexcept {
  if (feature == Feature::kFace) return FaceNormal(view, triangle);
  const auto& t = view.GetTriangle(triangle);
  if (feature == Feature::kEdge) {
    const std::uint32_t other = t.neighbour[index];
    const Vec3 own = FaceNormal(view, triangle);
    return other == kNoIndex ? own : Normalized(own + FaceNormal(view, other));
  }
  Vec3 sum;
  WalkRing(view, triangle, t.vertex[index], [&](std::uint32_t fan, int corner) noexcept {
    const Corners c = view.TriangleCorners(fan);
    const Vec3& apex = c[static_cast<std::size_t>(corner)];
    const Vec3 e1 = c[static_cast<std::size_t>((corner + 1) % 3)] - apex;
    const Vec3 e2 = c[static_cast<std::size_t>((corner + 2) % 3)] - apex;
    const Vec3 area = Cross(e1, e2);
    const double angle_rad = std::atan2(Norm(area), Dot(e1, e2));
    sum = sum + angle_rad * Normalized(area);
  });
  return Normalized(sum);
}

// True if the feature lies on the border of the mesh.
template <MeshView View>
bool OnBorder(const View& view, std::uint32_t triangle, Feature feature, int index) noexcept {
  if (feature == Feature::kFace) return false;
  const auto& t = view.GetTriangle(triangle);
  if (feature == Feature::kEdge) return t.neighbour[index] == kNoIndex;
  return !WalkRing(view, triangle, t.vertex[index], [](std::uint32_t, int) noexcept {});
}

extern template Vec3 Pseudonormal(const Surface&, std::uint32_t, Feature, int) noexcept;
extern template bool OnBorder(const Surface&, std::uint32_t, Feature, int) noexcept;

}  // namespace omni::haptics
