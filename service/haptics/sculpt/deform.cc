#include "service/haptics/sculpt/deform.h"

#include <limits>

#include "service/haptics/sculpt/shape.h"

namespace omni::haptics::sculpt {

double LongestStep(const PagedMesh& mesh, const Region& region) {
  constexpr double kShare = 0.25;
  double longest_m = std::numeric_limits<double>::infinity();
  for (const std::uint32_t t : TrianglesOf(mesh, region)) {
    const Triangle& triangle = mesh.GetTriangle(t);
    const Corners c = mesh.TriangleCorners(t);
    // A thin triangle turns over when a corner crosses the opposite edge: its least height is the measure.
    const double height_m = Norm(AreaVector(c)) / std::sqrt(LongestSquared(c));
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 apart = region.MoveOf(triangle.vertex[(k + 1) % 3]) - region.MoveOf(triangle.vertex[k]);
      const double rate = Norm(apart);
      if (rate > 0) longest_m = std::min(longest_m, kShare * height_m / rate);
    }
  }
  return longest_m;
}

std::size_t Displace(PagedMesh& mesh, const Region& region, double offset_m) {
  const std::vector<std::uint32_t> triangles = TrianglesOf(mesh, region);
  std::vector<Corners> before;
  before.reserve(triangles.size());
  for (const std::uint32_t t : triangles) before.push_back(mesh.TriangleCorners(t));
  std::vector<Vec3> old(region.size());
  std::vector<bool> stays(region.size(), false);
  IndexMap place;
  for (std::uint32_t i = 0; i < region.size(); ++i) {
    old[i] = mesh.VertexPosition(region.vertex(i));
    place.Set(region.vertex(i), i);
    const Vec3 moved = old[i] + offset_m * region.move(i);
    stays[i] = !Within(moved, kMaxCoordinate_m);
    if (!stays[i]) mesh.MoveVertex(region.vertex(i), moved);
  }
  // Put back the corners of what went wrong, until nothing is: at worst all stays as it was.
  std::size_t put_back = 0;
  for (bool again = true; again;) {
    again = false;
    for (std::size_t n = 0; n < triangles.size(); ++n) {
      if (MayBecome(before[n], mesh.TriangleCorners(triangles[n]), 0)) continue;
      const Triangle triangle = mesh.GetTriangle(triangles[n]);
      for (const std::uint32_t v : triangle.vertex) {
        const std::uint32_t i = place.Find(v);
        if (i == kNoIndex || stays[i]) continue;
        stays[i] = true;
        mesh.MoveVertex(v, old[i]);
        ++put_back;
        again = true;
      }
    }
  }
  for (const std::uint32_t t : triangles) mesh.Moved(t);
  return put_back;
}

}  // namespace omni::haptics::sculpt
