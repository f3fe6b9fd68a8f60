#include "service/haptics/sculpt/mesh/region.h"

#include <limits>

#include "service/haptics/geometry/topology.h"

namespace omni::haptics::sculpt {

void Region::Add(std::uint32_t vertex, double weight, const Vec3& move) {
  const std::uint32_t at = place_.Find(vertex);
  if (at == kNoIndex) {
    place_.Set(vertex, static_cast<std::uint32_t>(vertex_.size()));
    vertex_.push_back(vertex);
    weight_.push_back(weight);
    move_.push_back(move);
    return;
  }
  const double share = 1 / std::max(1.0, weight_[at] + weight);
  move_[at] = share * (move_[at] + move);
  weight_[at] = std::max(weight_[at], weight);
}

void Region::Remove(std::uint32_t vertex) {
  const std::uint32_t at = place_.Find(vertex);
  if (at == kNoIndex) return;
  vertex_[at] = vertex_.back();
  weight_[at] = weight_.back();
  move_[at] = move_.back();
  place_.Set(vertex_[at], at);
  vertex_.pop_back();
  weight_.pop_back();
  move_.pop_back();
  place_.Set(vertex, kNoIndex);
}

void Region::AddMiddle(std::uint32_t middle, std::uint32_t a, std::uint32_t b) {
  const double weight = 0.5 * (WeightOf(a) + WeightOf(b));
  if (weight > 0) Add(middle, weight, 0.5 * (MoveOf(a) + MoveOf(b)));
}

Patch PatchOf(const PagedMesh& mesh, const Region& region) {
  Patch patch;
  patch.reserve(2 * region.size() + 64);
  for (std::uint32_t i = 0; i < region.size(); ++i) {
    const std::uint32_t start = mesh.FirstTriangle(region.vertex(i));
    std::uint32_t current = start;
    do {
      const Triangle& t = mesh.GetTriangle(current);
      PatchTriangle triangle{current, {}};
      bool first = true;  // of its corners in the region, this one has the least place
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.at[k] = t.vertex[k] == region.vertex(i) ? i : region.Find(t.vertex[k]);
        first = first && triangle.at[k] >= i;
      }
      if (first) patch.push_back(triangle);
      current = t.neighbour[CornerOf(t, region.vertex(i))];
    } while (current != start);
  }
  return patch;
}

Weighted WeighBall(const PagedMesh& mesh, const SurfacePoint& at, const Brush& brush) {
  Weighted result;
  result.vertices = GeodesicBall(mesh, at, brush.radius_m, kMaxRegionVertices);
  if (result.vertices.size() > kMaxRegionVertices) return {};
  IndexMap place;
  for (std::uint32_t i = 0; i < result.vertices.size(); ++i) {
    GeodesicVertex& v = result.vertices[i];
    v.distance_m = FalloffShare(brush.falloff, v.distance_m / brush.radius_m);
    place.Set(v.vertex, i);
  }
  // N = sum over triangles of area normal times the mean weight of the corners   (3.2); each triangle comes once per
  // corner in the ball, with that corner's weight.
  Vec3 sum;
  double length_m = 0;
  std::size_t edges = 0;
  for (const GeodesicVertex& v : result.vertices) {
    const std::uint32_t start = mesh.FirstTriangle(v.vertex);
    std::uint32_t current = start;
    do {
      const Corners c = mesh.TriangleCorners(current);
      sum = sum + v.distance_m * AreaVector(c);
      const Triangle& t = mesh.GetTriangle(current);
      const auto corner = static_cast<std::size_t>(CornerOf(t, v.vertex));
      length_m += Norm(c[(corner + 1) % 3] - c[corner]);
      ++edges;
      current = t.neighbour[corner];
    } while (current != start);
  }
  result.mean_normal = Normalized(sum);
  if (!(Norm(sum) > 0)) result.mean_normal = Normalized(AreaVector(mesh.TriangleCorners(at.triangle)));
  result.mean_edge_m = edges > 0 ? length_m / static_cast<double>(edges) : 0;
  std::erase_if(result.vertices, [](const GeodesicVertex& v) { return !(v.distance_m > 0); });
  return result;
}

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

std::size_t DisplaceVertices(PagedMesh& mesh, const Region& region, const Patch& patch, double offset_m) {
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
    stays[i] = !IsWithin(moved, kMaxCoordinate_m);
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
