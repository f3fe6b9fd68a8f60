#include "service/tools/recordings/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace omni::tools {
namespace {

using base::Vec3;

constexpr double kAmbient = 0.45;                            // brightness of what the light does not reach
constexpr Vec3 kLight{-0.40824829, 0.40824829, 0.81649658};  // from it: along right, up and towards the viewer; unit

// Of a corner in cells; z: towards the viewer, m.
struct Cell {
  double x, y, z;
};

// The nearest triangle of each cell.
class DepthGrid {
 public:
  explicit DepthGrid(int cells)
      : cells_(cells), nearest_(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells), {kFar, kNobody}) {}

  // Cells whose centres it covers, or at least the one of its middle.
  void Add(std::uint32_t triangle, const std::array<Cell, 3>& c) {
    const double area = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
    const Cell middle{(c[0].x + c[1].x + c[2].x) / 3, (c[0].y + c[1].y + c[2].y) / 3, (c[0].z + c[1].z + c[2].z) / 3};
    Put(triangle, static_cast<int>(std::floor(middle.x)), static_cast<int>(std::floor(middle.y)), middle.z);
    if (std::abs(area) < 1e-9) return;
    const auto [x_from, x_to] = Range(c[0].x, c[1].x, c[2].x);
    const auto [y_from, y_to] = Range(c[0].y, c[1].y, c[2].y);
    for (int y = y_from; y <= y_to; ++y) {
      for (int x = x_from; x <= x_to; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double b1 = ((px - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (py - c[0].y)) / area;
        const double b2 = ((c[1].x - c[0].x) * (py - c[0].y) - (px - c[0].x) * (c[1].y - c[0].y)) / area;
        if (b1 < 0 || b2 < 0 || b1 + b2 > 1) continue;
        Put(triangle, x, y, c[0].z + b1 * (c[1].z - c[0].z) + b2 * (c[2].z - c[0].z));
      }
    }
  }

  std::vector<std::uint32_t> Seen() const {
    std::vector<std::uint32_t> seen;
    for (const auto& [z, triangle] : nearest_) {
      if (triangle != kNobody) seen.push_back(triangle);
    }
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    return seen;
  }

 private:
  static constexpr double kFar = -std::numeric_limits<double>::infinity();
  static constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

  std::pair<int, int> Range(double a, double b, double c) const {
    const auto in_grid = [this](double value) { return static_cast<int>(std::clamp(value, 0.0, cells_ - 1.0)); };
    return {in_grid(std::floor(std::min({a, b, c}))), in_grid(std::ceil(std::max({a, b, c})))};
  }
  void Put(std::uint32_t triangle, int x, int y, double z) {
    if (x < 0 || y < 0 || x >= cells_ || y >= cells_) return;
    auto& cell = nearest_[static_cast<std::size_t>(y) * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(x)];
    if (z > cell.first) cell = {z, triangle};
  }

  int cells_;
  std::vector<std::pair<double, std::uint32_t>> nearest_;
};

}  // namespace

std::vector<DrawnTriangle> SeenTriangles(const haptics::Scene& scene, const SceneView& view, int cells) {
  const auto triangles = scene.triangles();
  const Vec3 towards = base::Cross(view.right, view.up);
  const auto corner = [&](std::uint32_t triangle, int i) {
    const haptics::Vertex& vertex = scene.vertices()[triangles[triangle].vertex[i]];
    return Vec3{vertex.x, vertex.y, vertex.z};
  };
  const double per_m = cells / (2 * view.half_m);
  DepthGrid grid(cells);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    std::array<Cell, 3> at;
    for (int i = 0; i < 3; ++i) {
      const Vec3 from = corner(t, i) - view.centre_m;
      at[static_cast<std::size_t>(i)] = {(base::Dot(from, view.right) + view.half_m) * per_m,
                                         (base::Dot(from, view.up) + view.half_m) * per_m, base::Dot(from, towards)};
    }
    grid.Add(t, at);
  }
  std::vector<std::pair<double, DrawnTriangle>> drawn;
  for (const std::uint32_t t : grid.Seen()) {
    DrawnTriangle triangle{.corners_m = {corner(t, 0), corner(t, 1), corner(t, 2)}};
    const auto& c = triangle.corners_m;
    Vec3 normal = base::Normalized(base::Cross(c[1] - c[0], c[2] - c[0]));
    if (base::Dot(normal, towards) < 0) normal = -1.0 * normal;
    const double lit = base::Dot(normal, view.right) * kLight.x + base::Dot(normal, view.up) * kLight.y +
                       base::Dot(normal, towards) * kLight.z;
    triangle.brightness = kAmbient + (1 - kAmbient) * std::max(0.0, lit);
    drawn.emplace_back(base::Dot(c[0] + c[1] + c[2], towards), triangle);
  }
  std::stable_sort(drawn.begin(), drawn.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<DrawnTriangle> sorted;
  for (const auto& [z, triangle] : drawn) sorted.push_back(triangle);
  return sorted;
}

}  // namespace omni::tools
