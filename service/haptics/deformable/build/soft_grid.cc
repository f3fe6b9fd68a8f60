#include "service/haptics/deformable/build/soft_grid.h"

#include <algorithm>
#include <unordered_map>

#include "service/haptics/geometry/triangle_math.h"

namespace omni::haptics {
namespace {

constexpr double kMostCells = 20;

Vec3 CornerOf(const SoftNode& n) { return {n.position_base_m.x, n.position_base_m.y, n.position_base_m.z}; }

Corners CornersOf(const std::vector<SoftNode>& nodes, const SoftTriangle& t) {
  return {CornerOf(nodes[t.node[0]]), CornerOf(nodes[t.node[1]]), CornerOf(nodes[t.node[2]])};
}

// Nearest triangle; `start` is tried first, so that most others are refused by their box.
std::uint32_t NearestSoft(const std::vector<SoftNode>& nodes, const std::vector<SoftTriangle>& triangles, const Vec3& p,
                          std::uint32_t start, ClosestPoint& closest) {
  std::uint32_t best = start;
  closest = ClosestOnTriangle(CornersOf(nodes, triangles[start]), p);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Corners c = CornersOf(nodes, triangles[t]);
    const Vec3 lower = Min(c[0], Min(c[1], c[2]));
    const Vec3 upper = Max(c[0], Max(c[1], c[2]));
    const Vec3 outside = Max(Max(lower - p, p - upper), Vec3{});
    if (SquaredNorm(outside) >= closest.distance_squared) continue;
    const ClosestPoint candidate = ClosestOnTriangle(c, p);
    if (candidate.distance_squared >= closest.distance_squared) continue;
    closest = candidate;
    best = t;
  }
  return best;
}

}  // namespace

void ConnectSoftTriangles(std::vector<SoftTriangle>& triangles) {
  struct Side {
    std::uint32_t triangle;
    int edge;
  };
  std::unordered_map<std::uint64_t, Side> open;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      triangles[t].neighbour[k] = kNoSoftTriangle;
      const std::uint64_t a = triangles[t].node[k];
      const std::uint64_t b = triangles[t].node[(k + 1) % 3];
      const auto found = open.find((b << 32) | a);
      if (found == open.end()) {
        open[(a << 32) | b] = {t, k};
      } else {
        triangles[t].neighbour[k] = found->second.triangle;
        triangles[found->second.triangle].neighbour[found->second.edge] = t;
        open.erase(found);
      }
    }
  }
}

SoftGridResult MakeSoftGrid(const std::vector<SoftNode>& nodes, const std::vector<SoftTriangle>& triangles,
                            double lattice_cell_m) {
  Vec3 lower = CornerOf(nodes[0]);
  Vec3 upper = lower;
  for (const SoftNode& n : nodes) {
    lower = Min(lower, CornerOf(n));
    upper = Max(upper, CornerOf(n));
  }
  const Vec3 extent = upper - lower;
  SoftGridResult grid;
  grid.lower_m = lower;
  grid.cell_m = std::max(lattice_cell_m, std::max({extent.x, extent.y, extent.z}) / kMostCells);
  const double sides[] = {extent.x, extent.y, extent.z};
  for (std::size_t a = 0; a < 3; ++a) grid.count[a] = static_cast<std::uint32_t>(sides[a] / grid.cell_m) + 1;
  std::uint32_t last = 0;
  for (std::uint32_t k = 0; k < grid.count[2]; ++k) {
    for (std::uint32_t j = 0; j < grid.count[1]; ++j) {
      for (std::uint32_t i = 0; i < grid.count[0]; ++i) {
        ClosestPoint closest;
        last = NearestSoft(nodes, triangles, lower + grid.cell_m * Vec3{i + 0.5, j + 0.5, k + 0.5}, last, closest);
        grid.seed.push_back(last);
      }
    }
  }
  return grid;
}

SoftSkin HangOnSurface(const std::vector<SoftNode>& nodes, const std::vector<SoftTriangle>& triangles,
                       const SoftGridResult& grid, const Vec3& p) {
  const Vec3 cell = (1 / grid.cell_m) * (p - grid.lower_m);
  const auto index = [&](double x, std::size_t axis) {
    return static_cast<std::uint32_t>(std::clamp(x, 0.0, static_cast<double>(grid.count[axis] - 1)));
  };
  const std::uint32_t seed =
      grid.seed[(index(cell.z, 2) * grid.count[1] + index(cell.y, 1)) * grid.count[0] + index(cell.x, 0)];
  ClosestPoint closest;
  const std::uint32_t t = NearestSoft(nodes, triangles, p, seed, closest);
  const auto& w = closest.weights;
  return {t, {static_cast<float>(w[0]), static_cast<float>(w[1]), static_cast<float>(w[2])}};
}

}  // namespace omni::haptics
