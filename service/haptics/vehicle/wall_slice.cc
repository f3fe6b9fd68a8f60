#include "service/haptics/vehicle/wall_slice.h"

namespace omni::haptics {
namespace {

struct Slice {
  bool cut = false;
  Vec3 from, to;
};

// A corner is below the plane or not; edges between the two kinds are cut. A triangle within the plane is not.
Slice CutAt(const Corners& c, double z) noexcept {
  Slice slice;
  int found = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& a = c[k];
    const Vec3& b = c[(k + 1) % 3];
    if ((a.z < z) == (b.z < z)) continue;
    (found++ == 0 ? slice.from : slice.to) = a + ((z - a.z) / (b.z - a.z)) * (b - a);
  }
  slice.cut = found == 2;
  return slice;
}

Vec3 NearestOn(const Slice& slice, const Vec3& p) noexcept {
  const Vec3 along = slice.to - slice.from;
  const double length_squared = SquaredNorm(along);
  if (!(length_squared > 0)) return slice.from;
  return slice.from + std::clamp(Dot(p - slice.from, along) / length_squared, 0.0, 1.0) * along;
}

double LevelDistanceSquared(const TreeNode& node, int k, const Vec3& p) noexcept {
  const double dx = std::max({node.lower[0][k] - p.x, 0.0, p.x - node.upper[0][k]});
  const double dy = std::max({node.lower[1][k] - p.y, 0.0, p.y - node.upper[1][k]});
  return dx * dx + dy * dy;
}

void TryTriangle(const Surface& surface, std::uint32_t triangle, const Vec3& p, Wall& wall) noexcept {
  const Slice slice = CutAt(surface.TriangleCorners(triangle), p.z);
  if (!slice.cut) return;
  const Vec3 away = p - NearestOn(slice, p);
  const double distance_m = std::sqrt(away.x * away.x + away.y * away.y);
  if (!(distance_m < wall.distance_m)) return;
  wall = {true, distance_m, Normalized({away.x, away.y, 0}), surface.GetTriangle(triangle).material};
}

void SearchObject(const Surface& surface, const Object& object, const Vec3& p, Wall& wall) noexcept {
  std::array<std::uint32_t, (kTreeWidth - 1) * kMaxTreeDepth + kTreeWidth> stack;
  std::size_t size = 0;
  stack[size++] = object.root;
  while (size > 0) {
    const std::uint32_t child = stack[--size];
    if ((child & kLeafBit) != 0) {
      for (const std::uint32_t t : surface.Packet(child & kChildIndex).triangle) TryTriangle(surface, t, p, wall);
      continue;
    }
    const TreeNode& node = surface.Node(child);
    for (int k = 0; k < kTreeWidth; ++k) {
      if (!(node.lower[2][k] <= p.z && p.z <= node.upper[2][k])) continue;
      if (LevelDistanceSquared(node, k, p) < wall.distance_m * wall.distance_m) stack[size++] = node.child[k];
    }
  }
}

}  // namespace

Wall NearestWall(const Scene& scene, const Surface& surface, const Vec3& p, double reach_m) noexcept {
  Wall wall;
  wall.distance_m = reach_m;
  for (const Object& object : scene.objects()) {
    if ((object.flags & kCarWall) != 0) SearchObject(surface, object, p, wall);
  }
  return wall;
}

}  // namespace omni::haptics
