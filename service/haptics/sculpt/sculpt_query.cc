#include "service/haptics/sculpt/sculpt_query.h"

namespace omni::haptics::sculpt {
namespace {

constexpr double kFarthest_m = 1e6;  // what is farther, or no number, is nowhere
constexpr std::size_t kStack = 7 * kMaxTopDepth + 8;

// Position of the least value that is left; taken out by setting it to infinity.
std::size_t TakeLeast(std::array<float, 8>& values) noexcept {
  std::size_t least = 0;
  for (std::size_t k = 1; k < 8; ++k) {
    if (values[k] < values[least]) least = k;
  }
  values[least] = std::numeric_limits<float>::infinity();
  return least;
}

// Branch and bound, nearest box first, over nodes, then within a page over groups of triangles.
class NearestSearch {
 public:
  NearestSearch(const SculptSurface& surface, const Vec3& p, double max_distance_m, const Vec3& facing) noexcept
      : surface_(surface), p_(p), facing_(facing), test_(p), bound_(max_distance_m * max_distance_m) {}

  SculptNearest Run() noexcept {
    std::array<Entry, kStack> stack;
    std::size_t size = 0;
    stack[size++] = {0, 0};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (!(entry.distance_squared < bound_)) continue;
      if ((entry.child & kPageChild) != 0) {
        LookInPage(entry.child & ~kPageChild);
        continue;
      }
      const TopNode& node = surface_.Node(entry.child);
      const std::array<float, 8> distances = test_.DistancesSquared(node.boxes);
      const std::size_t first = size;
      for (std::size_t k = 0; k < 8; ++k) {
        if (node.child[k] == kNoIndex || !(distances[k] < bound_)) continue;
        std::size_t at = size++;  // insertion: farthest below, nearest on top
        for (; at > first && stack[at - 1].distance_squared < distances[k]; --at) stack[at] = stack[at - 1];
        stack[at] = {node.child[k], distances[k]};
      }
    }
    return best_;
  }

 private:
  struct Entry {
    std::uint32_t child;
    float distance_squared;
  };

  void LookInPage(std::uint32_t page) noexcept {
    const PageTree& tree = surface_.GetPage(page).tree;
    const std::array<float, 8> distances = test_.DistancesSquared(tree.top);
    std::array<float, 8> left = distances;
    for (int i = 0; i < 8; ++i) {
      const std::size_t k = TakeLeast(left);
      if (!(distances[k] < bound_)) return;
      const std::array<float, 8> parts = test_.DistancesSquared(tree.group[k]);
      for (std::size_t j = 0; j < 8; ++j) {
        if (parts[j] < bound_) LookInGroup(page, tree, static_cast<std::uint32_t>(8 * k + j));
      }
    }
  }

  void LookInGroup(std::uint32_t page, const PageTree& tree, std::uint32_t group) noexcept {
    for (std::uint32_t i = tree.GroupBegin(group); i < tree.GroupBegin(group + 1); ++i) {
      const std::uint32_t triangle = IndexOf(page, tree.order[i]);
      const Corners corners = surface_.TriangleCorners(triangle);
      const ClosestPoint closest = ClosestOnTriangle(corners, p_);
      if (!(closest.distance_squared < bound_) || Dot(AreaVector(corners), facing_) < 0) continue;
      bound_ = closest.distance_squared;
      best_ = {triangle, closest};
    }
  }

  const SculptSurface& surface_;
  Vec3 p_, facing_;
  PointTest test_;
  double bound_;
  SculptNearest best_;
};

class CrossingSearch {
 public:
  CrossingSearch(const SculptSurface& surface, const Vec3& start, const Vec3& end, const std::uint32_t* skip,
                 int skip_count) noexcept
      : surface_(surface), start_(start), end_(end), test_(start, end), skip_(skip), skip_count_(skip_count) {
    best_.t = 2;
  }

  SculptCrossing Run() noexcept {
    std::array<std::uint32_t, kStack> stack;
    std::size_t size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const std::uint32_t child = stack[--size];
      if ((child & kPageChild) != 0) {
        LookInPage(child & ~kPageChild);
        continue;
      }
      const TopNode& node = surface_.Node(child);
      for (std::size_t k = 0; k < 8; ++k) {
        if (node.child[k] != kNoIndex && !test_.Misses(node.boxes, k)) stack[size++] = node.child[k];
      }
    }
    return best_;
  }

 private:
  bool Skipped(std::uint32_t triangle) const noexcept {
    const std::uint32_t component = surface_.GetTriangle(triangle).component;
    return std::find(skip_, skip_ + skip_count_, component) != skip_ + skip_count_;
  }

  void LookInPage(std::uint32_t page) noexcept {
    const PageTree& tree = surface_.GetPage(page).tree;
    for (std::size_t k = 0; k < 8; ++k) {
      if (test_.Misses(tree.top, k)) continue;
      for (std::size_t j = 0; j < 8; ++j) {
        if (!test_.Misses(tree.group[k], j)) LookInGroup(page, tree, static_cast<std::uint32_t>(8 * k + j));
      }
    }
  }

  void LookInGroup(std::uint32_t page, const PageTree& tree, std::uint32_t group) noexcept {
    for (std::uint32_t i = tree.GroupBegin(group); i < tree.GroupBegin(group + 1); ++i) {
      const std::uint32_t triangle = IndexOf(page, tree.order[i]);
      const TriangleHit hit = IntersectTriangle(surface_.TriangleCorners(triangle), start_, end_);
      if (!hit.hit || !hit.front || !(hit.t < best_.t) || Skipped(triangle)) continue;
      best_ = {triangle, hit.t};
    }
  }

  const SculptSurface& surface_;
  Vec3 start_, end_;
  SegmentTest test_;
  const std::uint32_t* skip_;
  int skip_count_;
  SculptCrossing best_;
};

}  // namespace

SculptNearest NearestPoint(const SculptSurface& surface, const Vec3& p, double max_distance_m,
                           const Vec3& facing) noexcept {
  if (!Within(p, kFarthest_m)) return {};
  return NearestSearch(surface, p, max_distance_m, facing).Run();
}

SculptCrossing FirstCrossing(const SculptSurface& surface, const Vec3& start, const Vec3& end,
                             const std::uint32_t* skip, int skip_count) noexcept {
  if (!Within(start, kFarthest_m) || !Within(end, kFarthest_m)) return {kNoIndex, 2};
  return CrossingSearch(surface, start, end, skip, skip_count).Run();
}

SculptNearest FindAgain(const SculptSurface& surface, const Vec3& point_base_m, const Vec3& normal,
                        double reach_m) noexcept {
  const SculptNearest same = NearestPoint(surface, point_base_m, reach_m, normal);
  return same.triangle != kNoIndex ? same : NearestPoint(surface, point_base_m);
}

}  // namespace omni::haptics::sculpt
