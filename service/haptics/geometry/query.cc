#include "service/haptics/geometry/query.h"

#include "service/haptics/geometry/topology.h"

namespace omni::haptics {
namespace {

double Outside(double lower, double upper, double x) noexcept {
  return x < lower ? lower - x : (x > upper ? x - upper : 0);
}

double BoxDistanceSquared(const BvhNode& node, const Vec3& p) noexcept {
  const double dx = Outside(node.lower[0], node.upper[0], p.x);
  const double dy = Outside(node.lower[1], node.upper[1], p.y);
  const double dz = Outside(node.lower[2], node.upper[2], p.z);
  return dx * dx + dy * dy + dz * dz;
}

// Separating axes of segment and box   [Ericson 5.3.3]. `slack` keeps rounding on the safe side.
struct Segment {
  Vec3 middle, half, abs_half;
  Segment(const Vec3& start, const Vec3& end) noexcept
      : middle(0.5 * (start + end)),
        half(0.5 * (end - start)),
        abs_half{std::abs(half.x), std::abs(half.y), std::abs(half.z)} {}

  bool Misses(const BvhNode& node) const noexcept {
    constexpr double kSlack_m = 1e-9;
    const Vec3 m{middle.x - 0.5 * (double{node.lower[0]} + node.upper[0]),
                 middle.y - 0.5 * (double{node.lower[1]} + node.upper[1]),
                 middle.z - 0.5 * (double{node.lower[2]} + node.upper[2])};
    const Vec3 e{0.5 * (double{node.upper[0]} - node.lower[0]) + kSlack_m,
                 0.5 * (double{node.upper[1]} - node.lower[1]) + kSlack_m,
                 0.5 * (double{node.upper[2]} - node.lower[2]) + kSlack_m};
    if (std::abs(m.x) > e.x + abs_half.x) return true;
    if (std::abs(m.y) > e.y + abs_half.y) return true;
    if (std::abs(m.z) > e.z + abs_half.z) return true;
    const Vec3 a{abs_half.x + kSlack_m, abs_half.y + kSlack_m, abs_half.z + kSlack_m};
    if (std::abs(m.y * half.z - m.z * half.y) > e.y * a.z + e.z * a.y) return true;
    if (std::abs(m.z * half.x - m.x * half.z) > e.x * a.z + e.z * a.x) return true;
    return std::abs(m.x * half.y - m.y * half.x) > e.x * a.y + e.y * a.x;
  }
};

bool Skipped(std::uint32_t component, const std::uint32_t* skip, int skip_count) noexcept {
  for (int k = 0; k < skip_count; ++k) {
    if (skip[k] == component) return true;
  }
  return false;
}

}  // namespace

double BoxDistance(const BvhNode& node, const Vec3& p) noexcept { return std::sqrt(BoxDistanceSquared(node, p)); }

// Branch and bound, nearer child first.
NearestResult NearestPoint(const Surface& surface, const Object& object, const Vec3& p,
                           double max_distance_m) noexcept {
  struct Entry {
    std::uint32_t node;
    double distance_squared;
  };
  std::array<Entry, kMaxBvhDepth + 2> stack;
  std::size_t size = 0;
  NearestResult best;
  double bound = max_distance_m * max_distance_m;
  stack[size++] = {object.root, BoxDistanceSquared(surface.Node(object.root), p)};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (!(entry.distance_squared < bound)) continue;
    const BvhNode& node = surface.Node(entry.node);
    for (std::uint32_t k = 0; k < node.count; ++k) {
      const std::uint32_t triangle = surface.LeafTriangle(node.first + k);
      const ClosestPoint closest = ClosestOnTriangle(surface.TriangleCorners(triangle), p);
      if (!(closest.distance_squared < bound)) continue;
      bound = closest.distance_squared;
      best = {triangle, closest};
    }
    if (node.count > 0) continue;
    Entry near{node.first, BoxDistanceSquared(surface.Node(node.first), p)};
    Entry far{node.first + 1, BoxDistanceSquared(surface.Node(node.first + 1), p)};
    if (far.distance_squared < near.distance_squared) std::swap(near, far);
    stack[size++] = far;
    stack[size++] = near;
  }
  return best;
}

CrossingResult FirstCrossing(const Surface& surface, const Object& object, const Vec3& start, const Vec3& end,
                             const std::uint32_t* skip, int skip_count) noexcept {
  const bool double_sided = (object.flags & kDoubleSided) != 0;
  const Segment segment(start, end);
  std::array<std::uint32_t, kMaxBvhDepth + 2> stack;
  std::size_t size = 0;
  CrossingResult best;
  best.t = 2;
  stack[size++] = object.root;
  while (size > 0) {
    const BvhNode& node = surface.Node(stack[--size]);
    if (segment.Misses(node)) continue;
    for (std::uint32_t k = 0; k < node.count; ++k) {
      const std::uint32_t triangle = surface.LeafTriangle(node.first + k);
      const TriangleHit hit = IntersectTriangle(surface.TriangleCorners(triangle), start, end);
      if (!hit.hit || !(hit.t < best.t) || (!double_sided && !hit.front)) continue;
      if (Skipped(surface.GetTriangle(triangle).component, skip, skip_count)) continue;
      best = {triangle, hit.front, hit.t};
    }
    if (node.count > 0) continue;
    stack[size++] = node.first + 1;
    stack[size++] = node.first;
  }
  return best;
}

double SideOf(const Surface& surface, const NearestResult& nearest, const Vec3& p) noexcept {
  const Vec3 normal = Pseudonormal(surface, nearest.triangle, nearest.closest.feature, nearest.closest.index);
  return Dot(p - nearest.closest.point, normal) >= 0 ? 1 : -1;
}

}  // namespace omni::haptics
