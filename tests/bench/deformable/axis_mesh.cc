#include "tests/bench/deformable/axis_mesh.h"

#include <cmath>
#include <numbers>

namespace omni::bench {

SurfaceMesh TurnBody(const AxisBody& body, int around, int rings) {
  SurfaceMesh mesh;
  // Profile from the axis over the top, down the side, to the middle of the base.
  std::vector<std::array<double, 2>> profile;
  for (int k = 1; k <= rings; ++k) {
    const double r = body.radius_m * k / rings;
    profile.push_back({r, body.Top(r)});
  }
  profile.push_back({body.radius_m, 0});
  const auto n = static_cast<std::uint32_t>(around);
  for (const auto& [r, z] : profile) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const double angle = 2 * std::numbers::pi * j / n;
      mesh.vertices.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back({0, 0, body.Top(0)});
  mesh.vertices.push_back({0, 0, 0});
  const auto last = static_cast<std::uint32_t>(profile.size() - 1);
  for (std::uint32_t j = 0; j < n; ++j) {
    const std::uint32_t next = (j + 1) % n;
    mesh.triangles.push_back({top, j, next});
    mesh.triangles.push_back({top + 1, last * n + next, last * n + j});
    for (std::uint32_t k = 0; k < last; ++k) {
      mesh.triangles.push_back({k * n + j, (k + 1) * n + j, (k + 1) * n + next});
      mesh.triangles.push_back({k * n + j, (k + 1) * n + next, k * n + next});
    }
  }
  return mesh;
}

}  // namespace omni::bench
