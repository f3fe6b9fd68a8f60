#include "service/haptics/sculpt/mesh/deform.h"

#include <limits>

#include "service/haptics/sculpt/mesh/shape.h"

namespace omni::haptics::sculpt {

double LongestStep(const PagedMesh& mesh, const Region& region, const Patch& patch) {
  constexpr double kShare = 0.25;
  double longest2 = std::numeric_limits<double>::infinity();
  const auto move = [&region](std::uint32_t at) { return at == kNoIndex ? Vec3{} : region.move(at); };
  for (const PatchTriangle& t : patch) {
    const Corners c = mesh.TriangleCorners(t.triangle);
    const std::array<Vec3, 3> rate{move(t.at[0]), move(t.at[1]), move(t.at[2])};
    const double fastest2 =
        std::max({SquaredNorm(rate[1] - rate[0]), SquaredNorm(rate[2] - rate[1]), SquaredNorm(rate[0] - rate[2])});
    // It turns over when a corner crosses the opposite edge: the least height is the measure.
    const double height2 = SquaredNorm(AreaVector(c)) / LongestSquared(c);
    if (fastest2 > 0) longest2 = std::min(longest2, kShare * kShare * height2 / fastest2);
  }
  return std::sqrt(longest2);
}

std::size_t Displace(PagedMesh& mesh, const Region& region, const Patch& patch, double offset_m) {
  std::vector<Corners> before;
  before.reserve(patch.size());
  for (const PatchTriangle& t : patch) {
    before.push_back(mesh.TriangleCorners(t.triangle));
    mesh.Moved(t.triangle);
  }
  std::vector<Vec3> old(region.size());
  std::vector<bool> stays(region.size(), false);
  for (std::size_t i = 0; i < region.size(); ++i) {
    old[i] = mesh.VertexPosition(region.vertex(i));
    const Vec3 moved = old[i] + offset_m * region.move(i);
    stays[i] = !Within(moved, kMaxCoordinate_m);
    if (!stays[i]) mesh.MoveVertex(region.vertex(i), moved);
  }
  // Put back the corners of what went wrong, until nothing is: at worst all stays as it was.
  std::size_t put_back = 0;
  for (bool again = true; again;) {
    again = false;
    for (std::size_t n = 0; n < patch.size(); ++n) {
      if (MayBecome(before[n], mesh.TriangleCorners(patch[n].triangle), 0)) continue;
      for (const std::uint32_t i : patch[n].at) {
        if (i == kNoIndex || stays[i]) continue;
        stays[i] = true;
        mesh.MoveVertex(region.vertex(i), old[i]);
        ++put_back;
        again = true;
      }
    }
  }
  return put_back;
}

}  // namespace omni::haptics::sculpt
