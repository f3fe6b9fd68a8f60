#include "service/haptics/geometry/topology.h"

namespace omni::haptics {
namespace {

Vec3 FaceNormal(const Surface& surface, std::uint32_t triangle) noexcept {
  return Normalized(AreaVector(surface.TriangleCorners(triangle)));
}

}  // namespace

Vec3 Pseudonormal(const Surface& surface, std::uint32_t triangle, Feature feature, int index) noexcept {
  const Triangle& t = surface.GetTriangle(triangle);
  if (feature == Feature::kFace) return FaceNormal(surface, triangle);
  if (feature == Feature::kEdge) {
    const std::uint32_t other = t.neighbour[index];
    const Vec3 own = FaceNormal(surface, triangle);
    return other == kNoIndex ? own : Normalized(own + FaceNormal(surface, other));
  }
  Vec3 sum;
  WalkRing(surface, triangle, t.vertex[index], [&](std::uint32_t fan, int corner) noexcept {
    const Corners c = surface.TriangleCorners(fan);
    const Vec3& apex = c[static_cast<std::size_t>(corner)];
    const Vec3 e1 = c[static_cast<std::size_t>((corner + 1) % 3)] - apex;
    const Vec3 e2 = c[static_cast<std::size_t>((corner + 2) % 3)] - apex;
    const Vec3 area = Cross(e1, e2);
    const double angle_rad = std::atan2(Norm(area), Dot(e1, e2));
    sum = sum + angle_rad * Normalized(area);
  });
  return Normalized(sum);
}

bool OnBorder(const Surface& surface, std::uint32_t triangle, Feature feature, int index) noexcept {
  const Triangle& t = surface.GetTriangle(triangle);
  if (feature == Feature::kFace) return false;
  if (feature == Feature::kEdge) return t.neighbour[index] == kNoIndex;
  return !WalkRing(surface, triangle, t.vertex[index], [](std::uint32_t, int) noexcept {});
}

}  // namespace omni::haptics
