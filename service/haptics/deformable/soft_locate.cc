#include "service/haptics/deformable/soft_body.h"

#include "service/haptics/geometry/triangle_math.h"

namespace omni::haptics {
namespace {

constexpr int kMaxSoftMoves = 32;
constexpr int kMaxSoftFan = 24;
constexpr double kHintReach_cells = 1.5;  // a hint further from the point than this is ignored

Vec3 PositionOf(const SoftNode& node) noexcept {
  return {node.position_base_m.x, node.position_base_m.y, node.position_base_m.z};
}

ClosestPoint ClosestOnSoft(const SoftBodyView& body, std::uint32_t triangle, const Vec3& p) noexcept {
  const SoftTriangle& t = body.GetTriangle(triangle);
  return ClosestOnTriangle(
      {PositionOf(body.Node(t.node[0])), PositionOf(body.Node(t.node[1])), PositionOf(body.Node(t.node[2]))}, p);
}

std::uint32_t SeedOf(const SoftBodyView& body, const Vec3& p) noexcept {
  const SoftHeader& h = body.header();
  const auto cell = [&](double x, int axis) {
    const double index = (x - h.grid_lower_m[axis]) / h.grid_cell_m;
    const double last = h.grid_count[axis] - 1;
    return static_cast<std::uint32_t>(std::clamp(index, 0.0, last));
  };
  return body.Seed((cell(p.z, 2) * h.grid_count[1] + cell(p.y, 1)) * h.grid_count[0] + cell(p.x, 0));
}

struct SoftBest {
  std::uint32_t triangle;
  ClosestPoint closest;
};

// Tries a triangle; true if it is strictly nearer.
bool TrySoft(const SoftBodyView& body, std::uint32_t triangle, const Vec3& p, SoftBest& best) noexcept {
  if (triangle == kNoSoftTriangle) return false;
  const ClosestPoint closest = ClosestOnSoft(body, triangle, p);
  if (!(closest.distance_squared < best.closest.distance_squared)) return false;
  best = {triangle, closest};
  return true;
}

// The triangles around corner `corner` of best.triangle, one way and then the other.
bool TrySoftFan(const SoftBodyView& body, int corner, const Vec3& p, SoftBest& best) noexcept {
  const std::uint32_t start = best.triangle;
  const std::uint32_t node = body.GetTriangle(start).node[corner];
  bool moved = false;
  for (const int turn : {0, 2}) {
    std::uint32_t current = start;
    for (int k = 0; k < kMaxSoftFan; ++k) {
      const SoftTriangle& t = body.GetTriangle(current);
      const int at = t.node[0] == node ? 0 : (t.node[1] == node ? 1 : 2);
      current = t.neighbour[(at + turn) % 3];
      if (current == kNoSoftTriangle || current == start) break;
      moved = TrySoft(body, current, p, best) || moved;
    }
  }
  return moved;
}

}  // namespace

SoftPlace LocateOnSoftBody(const SoftBodyView& body, const Vec3& point, std::uint32_t hint) noexcept {
  if (!IsWithin(point, 1e6)) return {0, {1, 0, 0}};
  SoftBest best{};
  bool hinted = hint < body.header().triangle_count;
  if (hinted) {
    best = {hint, ClosestOnSoft(body, hint, point)};
    const double reach_m = kHintReach_cells * body.header().cell_m;
    hinted = best.closest.distance_squared < reach_m * reach_m;
  }
  if (!hinted) {
    const std::uint32_t seed = SeedOf(body, point);
    best = {seed, ClosestOnSoft(body, seed, point)};
  }
  for (int move = 0; move < kMaxSoftMoves; ++move) {
    const Feature feature = best.closest.feature;
    const int index = best.closest.index;
    if (feature == Feature::kFace) break;
    const bool moved = feature == Feature::kEdge
                           ? TrySoft(body, body.GetTriangle(best.triangle).neighbour[index], point, best)
                           : TrySoftFan(body, index, point, best);
    if (!moved) break;
  }
  const auto& w = best.closest.weights;
  return {best.triangle, {w[0], w[1], w[2]}};
}

}  // namespace omni::haptics
