#include "scenes/generator/pictures/rest_surface.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>

#include "service/haptics/geometry/triangle_math.h"

namespace omni::scenes {
namespace {

constexpr double kCells = 48;        // along the longest side
constexpr double kOffCorner = 0.15;  // of the way to the middle: which side of a painted edge a corner is on
constexpr double kShowFrom = 0.06;   // share of the largest displacement where its colour begins ...
constexpr double kShowWhole = 0.30;  // ... and where nothing is left of the paint
const Vec kSomewhat(0.98, 0.78, 0.03), kMuch(0.80, 0.02, 0.01);

// So that nothing is coloured but what has moved.
Vec Greyed(const Vec& paint) { return Vec(0.22 + 0.5 * glm::dot(paint, Vec(0.213, 0.715, 0.072))); }

base::Vec3 AsPoint(const Vec& p) { return {p.x, p.y, p.z}; }

bool HasMesh(const std::vector<DrawnMesh>& meshes, const std::string& name) {
  return std::any_of(meshes.begin(), meshes.end(), [&](const DrawnMesh& mesh) { return mesh.name == name; });
}

}  // namespace

RestSurface::RestSurface(const std::vector<DrawnMesh>& meshes) {
  Vec upper(-1e9);
  for (const DrawnMesh& drawn : meshes) {
    for (const Triangle& t : drawn.mesh.triangles) {
      PaintedTriangle painted;
      for (std::size_t k = 0; k < 3; ++k) {
        painted.corner[k] = drawn.mesh.positions[t[k]];
        painted.colour[k] = drawn.mesh.colours[t[k]];
        lower_ = glm::min(lower_, painted.corner[k]);
        upper = glm::max(upper, painted.corner[k]);
      }
      triangles_.push_back(painted);
    }
  }
  const Vec size = upper - lower_;
  cell_m_ = std::max({size.x, size.y, size.z, 1e-6}) / kCells;
  count_ = Cell(size / cell_m_) + 1;
  cells_.resize(static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) *
                static_cast<std::size_t>(count_.z));
  for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
    const Vec(&c)[3] = triangles_[i].corner;
    const Cell from = CellOf(glm::min(c[0], glm::min(c[1], c[2]))), to = CellOf(glm::max(c[0], glm::max(c[1], c[2])));
    for (int z = from.z; z <= to.z; ++z) {
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) cells_[IndexOf({x, y, z})].push_back(i);
      }
    }
  }
}

RestSurface::Cell RestSurface::CellOf(const Vec& p) const {
  return glm::clamp(Cell(glm::floor((p - lower_) / cell_m_)), Cell(0), count_ - 1);
}

std::size_t RestSurface::IndexOf(const Cell& cell) const {
  const auto row =
      static_cast<std::size_t>(cell.z) * static_cast<std::size_t>(count_.y) + static_cast<std::size_t>(cell.y);
  return row * static_cast<std::size_t>(count_.x) + static_cast<std::size_t>(cell.x);
}

// All cells within a reach that doubles until the nearest triangle found is within it.
RestPlace RestSurface::Nearest(const Vec& p) const {
  RestPlace best{1e9, Vec(0.0)};
  for (double reach_m = cell_m_; best.distance_m > reach_m / 2 && reach_m < 1e6; reach_m *= 2) {
    const Cell from = CellOf(p - reach_m), to = CellOf(p + reach_m);
    for (int z = from.z; z <= to.z; ++z) {
      for (int y = from.y; y <= to.y; ++y) {
        for (int x = from.x; x <= to.x; ++x) {
          for (const std::uint32_t i : cells_[IndexOf({x, y, z})]) {
            const PaintedTriangle& t = triangles_[i];
            const auto at = haptics::ClosestOnTriangle(
                {AsPoint(t.corner[0]), AsPoint(t.corner[1]), AsPoint(t.corner[2])}, AsPoint(p));
            const Vec place = t.corner[0] * at.weights[0] + t.corner[1] * at.weights[1] + t.corner[2] * at.weights[2];
            const double distance_m = glm::length(place - p);
            if (!(distance_m < best.distance_m)) continue;
            best = {distance_m,
                    t.colour[0] * at.weights[0] + t.colour[1] * at.weights[1] + t.colour[2] * at.weights[2]};
          }
        }
      }
    }
  }
  return best;
}

Vec DisplacementColour(double share, const Vec& paint) {
  const double covers = std::clamp((share - kShowFrom) / (kShowWhole - kShowFrom), 0.0, 1.0);
  const double much = std::clamp((share - kShowWhole) / (1 - kShowWhole), 0.0, 1.0);
  return glm::mix(paint, glm::mix(kSomewhat, kMuch, much), covers);
}

std::vector<DrawnMesh> PaintLike(const std::vector<DrawnMesh>& rest, std::vector<DrawnMesh> meshes,
                                 double displacement_max_m) {
  std::vector<DrawnMesh> replaced, others;
  for (const DrawnMesh& mesh : rest) (HasMesh(meshes, mesh.name) ? replaced : others).push_back(mesh);
  if (replaced.empty()) return meshes;
  const RestSurface surface(replaced);
  for (DrawnMesh& drawn : meshes) {
    DrawnMesh painted{.name = drawn.name, .mesh = {}, .normals = {}, .roughness = replaced[0].roughness};
    for (const Triangle& t : drawn.mesh.triangles) {
      const Vec middle = (drawn.mesh.positions[t[0]] + drawn.mesh.positions[t[1]] + drawn.mesh.positions[t[2]]) / 3.0;
      const auto first = static_cast<std::uint32_t>(painted.mesh.positions.size());
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec& corner = drawn.mesh.positions[t[k]];
        Vec colour = surface.Nearest(glm::mix(corner, middle, kOffCorner)).colour;
        if (displacement_max_m > 0) {
          colour = Greyed(colour);
          colour = DisplacementColour(surface.Nearest(corner).distance_m / displacement_max_m, colour);
        }
        painted.mesh.positions.push_back(corner);
        painted.mesh.colours.push_back(colour);
        painted.normals.push_back(drawn.normals[t[k]]);
      }
      painted.mesh.triangles.push_back({first, first + 1, first + 2});
    }
    drawn = std::move(painted);
  }
  std::move(others.begin(), others.end(), std::back_inserter(meshes));
  return meshes;
}

}  // namespace omni::scenes
