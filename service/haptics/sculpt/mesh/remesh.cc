#include "service/haptics/sculpt/mesh/remesh.h"

#include <limits>
#include <span>

#include "service/haptics/geometry/topology.h"
#include "service/haptics/sculpt/mesh/crossing.h"
#include "service/haptics/sculpt/mesh/mesh_ops.h"
#include "service/haptics/sculpt/mesh/region.h"

namespace omni::haptics::sculpt {
namespace {

constexpr double kFlatCosine = 0.9;     // edges sharper than about 26 degrees are left alone: they are features
constexpr double kSmoothCosine = 0.96;  // to the mean normal: only where all are within 16 degrees is there one tangent
constexpr double kFlat_m = 4e-6;        // nearer to the surface without it, a vertex is not needed
constexpr double kGoodShape = 0.3;      // of a triangle; see ShapeOf
constexpr std::size_t kMaxChanges = 200'000;  // per call; the remainder is split by the next

double EdgeSquared(const Corners& c, std::size_t k) noexcept { return SquaredNorm(c[(k + 1) % 3] - c[k]); }

std::uint32_t LongestEdge(const Corners& c) noexcept {
  std::uint32_t longest = 0;
  for (std::uint32_t k = 1; k < 3; ++k) {
    if (EdgeSquared(c, k) > EdgeSquared(c, longest)) longest = k;
  }
  return longest;
}

// From a triangle over its longest edge to the next with a longer one, until two share their longest edge: splitting
// that one keeps every angle above half the least there was [Rivara, Longest-edge propagation path, 1997].
Edge LongestOnPath(const PagedMesh& mesh, std::uint32_t triangle) noexcept {
  while (true) {
    const Corners c = mesh.TriangleCorners(triangle);
    const std::uint32_t k = LongestEdge(c);
    const std::uint32_t other = mesh.GetTriangle(triangle).neighbour[k];
    const Corners o = mesh.TriangleCorners(other);
    if (!(EdgeSquared(o, LongestEdge(o)) > EdgeSquared(c, k))) return {triangle, k};
    triangle = other;
  }
}

class Remesher {
 public:
  Remesher(PagedMesh& mesh, const EdgeRange& edges, Region& region, RemeshCounts& counts)
      : mesh_(mesh),
        long_squared_(edges.long_m * edges.long_m),
        short_squared_(edges.short_m * edges.short_m),
        region_(region),
        counts_(counts) {}

  bool TooLong(std::uint32_t t) const noexcept { return LongestSquared(mesh_.TriangleCorners(t)) > long_squared_; }

  bool TooShort(std::uint32_t t) const noexcept { return ShortestSquared(mesh_.TriangleCorners(t)) < short_squared_; }

  // The stroke moves a corner of it.
  bool IsMoved(std::uint32_t t) const noexcept {
    const Triangle& triangle = mesh_.GetTriangle(t);
    return std::any_of(std::begin(triangle.vertex), std::end(triangle.vertex),
                       [this](std::uint32_t v) { return region_.Has(v); });
  }

  // Until the triangle's own longest edge is short enough. False: the mesh or the call is at its limit.
  bool SplitUntilShort(std::uint32_t t) {
    while (TooLong(t)) {
      const Edge edge = LongestOnPath(mesh_, t);
      const Diamond d = DiamondOf(mesh_, edge);
      const Vec3 middle = 0.5 * (mesh_.VertexPosition(d.a) + mesh_.VertexPosition(d.b));
      if (changed_.size() > kMaxChanges) return false;
      const std::uint32_t m = SplitEdge(mesh_, edge, middle);
      if (m == kNoIndex) return false;
      ++counts_.splits;
      Changed(m);
      Announce(Fan(mesh_, m));
      region_.AddMiddle(m, d.a, d.b, mesh_.VertexPosition(d.b) - mesh_.VertexPosition(d.a));
    }
    return true;
  }

  // Then the parts that the splits left, as far as `counts(triangle)`.
  template <class Counts>
  void SplitParts(Counts&& counts) {
    for (std::size_t i = 0; i < changed_.size(); ++i) {
      const Fan fan(mesh_, changed_[i]);
      for (int k = 0; k < fan.size(); ++k) {
        if (counts(fan.triangle(k)) && !SplitUntilShort(fan.triangle(k))) return;
      }
    }
  }

  void CollapseShort(std::uint32_t t) {
    for (std::uint32_t k = 0; k < 3 && mesh_.IsLive(t); ++k) {
      if (EdgeSquared(mesh_.TriangleCorners(t), k) < short_squared_ && TryCollapse({t, k})) return;
    }
  }

  // Merges the vertex into the neighbour by which the surface changes least, if that is by no more than can be felt.
  void TakeOut(std::uint32_t v) {
    const Fan fan(mesh_, v);
    if (!HasOneMaterial(fan)) return;
    Diamond best{};
    double least_m2 = kFlat_m * kFlat_m;
    for (int i = 0; i < fan.size(); ++i) {
      const std::uint32_t t = fan.triangle(i);
      const Diamond d = DiamondOf(mesh_, {t, static_cast<std::uint32_t>(CornerOf(mesh_.GetTriangle(t), v))});
      const double away_m2 = AwayWithout(fan, d);
      if (!(away_m2 < least_m2)) continue;
      best = d;
      least_m2 = away_m2;
    }
    if (!(least_m2 < kFlat_m * kFlat_m) || !StaysFlat(fan, best) || CrossesWithout(fan, best)) return;
    Collapse(best, fan);
  }

  // Edges around what was changed.
  void FlipForValence() {
    const std::size_t changed = changed_.size();
    for (std::size_t i = 0; i < changed; ++i) {
      if (!region_.Has(changed_[i])) continue;
      const Fan fan(mesh_, changed_[i]);
      for (int n = 0; n < fan.size(); ++n) {
        for (std::uint32_t k = 0; k < 3; ++k) TryFlip({fan.triangle(n), k});
      }
    }
  }

  void SmoothChanged() {
    for (const std::uint32_t v : changed_) {
      if (region_.Has(v)) TrySmooth(v);
    }
  }

  const std::vector<std::uint32_t>& changed() const noexcept { return changed_; }

 private:
  void Changed(std::uint32_t v) {
    if (seen_.Has(v)) return;
    seen_.Set(v, 1);
    changed_.push_back(v);
  }

  Vec3 Normal(std::uint32_t t) const noexcept { return Normalized(AreaVector(mesh_.TriangleCorners(t))); }

  // All triangles of the fan but `except`, with `vertex` moved to `position`.
  bool FanMayMove(const Fan& fan, std::uint32_t vertex, const Vec3& position, const Diamond* except,
                  double longest_squared) const noexcept {
    for (int i = 0; i < fan.size(); ++i) {
      if (except != nullptr && (fan.triangle(i) == except->t || fan.triangle(i) == except->o)) continue;
      const Corners before = mesh_.TriangleCorners(fan.triangle(i));
      Corners after = before;
      const Triangle& t = mesh_.GetTriangle(fan.triangle(i));
      for (std::size_t k = 0; k < 3; ++k) {
        if (t.vertex[k] == vertex) after[k] = position;
      }
      if (!MayBecome(before, after, kFlatCosine) || LongestSquared(after) > longest_squared) return false;
    }
    return true;
  }

  // The end that the stroke moves less goes into the other, which stays where it is: the top of a bump keeps its
  // height.
  bool TryCollapse(const Edge& edge) {
    Diamond d = DiamondOf(mesh_, edge);
    if (!region_.Has(d.a) || !region_.Has(d.b)) return false;
    if (region_.WeightOf(d.a) > region_.WeightOf(d.b)) {
      d = DiamondOf(mesh_, {d.o, static_cast<std::uint32_t>(CornerOf(mesh_.GetTriangle(d.o), d.b))});
    }
    const Fan fan_a(mesh_, d.a), fan_b(mesh_, d.b);
    if (!CanCollapse(d, mesh_, fan_a, fan_b)) return false;
    const Vec3 there = mesh_.VertexPosition(d.b);
    if (!FanMayMove(fan_a, d.a, there, &d, long_squared_) || CrossesWithout(fan_a, d)) return false;
    Collapse(d, fan_a);
    return true;
  }

  void Collapse(const Diamond& d, const Fan& fan_a) {
    CollapseEdge(mesh_, d, fan_a);
    Announce(fan_a);
    region_.Remove(d.a);
    ++counts_.collapses;
    Changed(d.b);
  }

  void Announce(const Fan& fan) {
    for (int i = 0; i < fan.size(); ++i) crossing_.Changed(fan.triangle(i));
  }

  // The vertex and its triangles, at another place.
  void Place(std::uint32_t vertex, const Fan& fan, const Vec3& position) {
    mesh_.MoveVertex(vertex, position);
    for (int i = 0; i < fan.size(); ++i) mesh_.Moved(fan.triangle(i));
    Announce(fan);
  }

  // Something passes through something if d.a goes into d.b.
  bool CrossesWithout(const Fan& fan_a, const Diamond& d) {
    const Vec3 here = mesh_.VertexPosition(d.a);
    Place(d.a, fan_a, mesh_.VertexPosition(d.b));
    bool crosses = false;
    for (int i = 0; i < fan_a.size() && !crosses; ++i) {
      const std::uint32_t t = fan_a.triangle(i);
      crosses = t != d.t && t != d.o && crossing_.CrossesAnother(t, {d.t, d.o}, d.a, d.b);
    }
    Place(d.a, fan_a, here);
    return crosses;
  }

  bool HasOneMaterial(const Fan& fan) const noexcept {
    for (int i = 1; i < fan.size(); ++i) {
      if (mesh_.GetTriangle(fan.triangle(i)).material != mesh_.GetTriangle(fan.triangle(0)).material) return false;
    }
    return true;
  }

  // Square of the distance that the surface keeps from d.a when that goes into d.b; infinite: it must not.
  double AwayWithout(const Fan& fan_a, const Diamond& d) const noexcept {
    constexpr double kNever = std::numeric_limits<double>::infinity();
    if (!CanCollapse(d, mesh_, fan_a, Fan(mesh_, d.b))) return kNever;
    const Vec3 here = mesh_.VertexPosition(d.a), there = mesh_.VertexPosition(d.b);
    double least_m2 = kNever, shape = 1, shape_before = 1;
    for (int i = 0; i < fan_a.size(); ++i) {
      const std::uint32_t t = fan_a.triangle(i);
      Corners c = mesh_.TriangleCorners(t);
      shape_before = std::min(shape_before, ShapeOf(c));
      if (t == d.t || t == d.o) continue;
      c[static_cast<std::size_t>(CornerOf(mesh_.GetTriangle(t), d.a))] = there;
      shape = std::min(shape, ShapeOf(c));
      least_m2 = std::min(least_m2, ClosestOnTriangle(c, here).distance_squared);
    }
    if (!(least_m2 < kFlat_m * kFlat_m) || shape < std::min(kGoodShape, shape_before)) return kNever;
    return FanMayMove(fan_a, d.a, there, &d, long_squared_) ? least_m2 : kNever;
  }

  // The middles of the edges that go are near the surface with the new ones, and the other way round.
  bool StaysFlat(const Fan& fan, const Diamond& d) const {
    std::array<Corners, kMaxValence> old, made;
    std::size_t count = 0;
    const Vec3 here = mesh_.VertexPosition(d.a), there = mesh_.VertexPosition(d.b);
    for (int i = 0; i < fan.size(); ++i) {
      const Corners c = mesh_.TriangleCorners(fan.triangle(i));
      old[static_cast<std::size_t>(i)] = c;
      if (fan.triangle(i) == d.t || fan.triangle(i) == d.o) continue;
      made[count] = c;
      made[count++][static_cast<std::size_t>(CornerOf(mesh_.GetTriangle(fan.triangle(i)), d.a))] = there;
    }
    const auto is_near = [](const Vec3& p, std::span<const Corners> surface) {
      return std::any_of(surface.begin(), surface.end(), [&](const Corners& c) {
        return ClosestOnTriangle(c, p).distance_squared < kFlat_m * kFlat_m;
      });
    };
    for (int i = 0; i < fan.size(); ++i) {
      const Vec3 end = mesh_.VertexPosition(fan.next(i));
      if (!is_near(0.5 * (here + end), {made.data(), count})) return false;
      if (!is_near(0.5 * (there + end), {old.data(), static_cast<std::size_t>(fan.size())})) return false;
    }
    return true;
  }

  static int Uneven(int valence) noexcept { return std::abs(valence - 6); }

  void TryFlip(const Edge& edge) {
    const Diamond d = DiamondOf(mesh_, edge);
    const Fan fan_a(mesh_, d.a), fan_b(mesh_, d.b), fan_c(mesh_, d.c), fan_d(mesh_, d.d);
    const int a = fan_a.size(), b = fan_b.size(), c = fan_c.size(), e = fan_d.size();
    if (a == 0 || b == 0 || c == 0 || e == 0 || c == kMaxValence || e == kMaxValence) return;
    if (Uneven(a - 1) + Uneven(b - 1) + Uneven(c + 1) + Uneven(e + 1) >=
        Uneven(a) + Uneven(b) + Uneven(c) + Uneven(e)) {
      return;
    }
    if (!CanFlip(mesh_, d, fan_c, a, b) || !(Dot(Normal(d.t), Normal(d.o)) > kFlatCosine)) return;
    const Vec3 pa = mesh_.VertexPosition(d.a), pb = mesh_.VertexPosition(d.b), pc = mesh_.VertexPosition(d.c),
               pd = mesh_.VertexPosition(d.d);
    const Corners t_old{pa, pb, pc}, o_old{pb, pa, pd}, t_new{pd, pb, pc}, o_new{pc, pa, pd};
    if (SquaredNorm(pd - pc) > long_squared_ || !MayBecome(t_old, t_new, kFlatCosine) ||
        !MayBecome(o_old, o_new, kFlatCosine)) {
      return;
    }
    if (std::min(ShapeOf(t_new), ShapeOf(o_new)) < 0.5 * std::min(ShapeOf(t_old), ShapeOf(o_old))) return;
    FlipEdge(mesh_, d);
    crossing_.Changed(d.t);
    crossing_.Changed(d.o);
    if (crossing_.CrossesAnother(d.t) || crossing_.CrossesAnother(d.o)) {
      FlipEdge(mesh_, DiamondOf(mesh_, {d.t, 2}));  // c - d becomes a - b again; the two have changed places
      crossing_.Changed(d.t);
      return crossing_.Changed(d.o);
    }
    ++counts_.flips;
    for (const std::uint32_t v : {d.a, d.b, d.c, d.d}) Changed(v);
  }

  // Half the way to the middle of the neighbours, along the tangent plane.   (4.3)
  void TrySmooth(std::uint32_t v) {
    const Fan fan(mesh_, v);
    if (fan.size() == 0) return;
    Vec3 middle, normal;
    for (int i = 0; i < fan.size(); ++i) {
      middle = middle + (1.0 / fan.size()) * mesh_.VertexPosition(fan.next(i));
      normal = normal + AreaVector(mesh_.TriangleCorners(fan.triangle(i)));
    }
    normal = Normalized(normal);
    for (int i = 0; i < fan.size(); ++i) {
      if (!(Dot(Normal(fan.triangle(i)), normal) > kSmoothCosine)) return;
    }
    const Vec3 here = mesh_.VertexPosition(v);
    const Vec3 way = 0.5 * (middle - here);
    const Vec3 there = PagedMesh::AsStored(here + (way - Dot(way, normal) * normal));
    const double longest = std::max(long_squared_, LongestAround(fan));
    if (!FanMayMove(fan, v, there, nullptr, longest)) return;
    Place(v, fan, there);
    for (int i = 0; i < fan.size(); ++i) {
      if (crossing_.CrossesAnother(fan.triangle(i))) return Place(v, fan, here);
    }
    ++counts_.smoothed;
  }

  double LongestAround(const Fan& fan) const noexcept {
    double longest = 0;
    for (int i = 0; i < fan.size(); ++i) {
      longest = std::max(longest, LongestSquared(mesh_.TriangleCorners(fan.triangle(i))));
    }
    return longest;
  }

  PagedMesh& mesh_;
  double long_squared_, short_squared_;
  Region& region_;
  RemeshCounts& counts_;
  CrossingCheck crossing_{mesh_, region_.up()};
  std::vector<std::uint32_t> changed_;
  IndexMap seen_;
};

// Triangles that reach into the ball, found from neighbour to neighbour.
std::vector<std::uint32_t> TrianglesInBall(const PagedMesh& mesh, const SurfacePoint& at, double radius_m) {
  std::vector<std::uint32_t> found{at.triangle};
  IndexMap seen;
  seen.Set(at.triangle, 1);
  for (std::size_t head = 0; head < found.size() && found.size() < 4 * kMaxRegionVertices; ++head) {
    for (const std::uint32_t other : mesh.GetTriangle(found[head]).neighbour) {
      if (seen.Has(other)) continue;
      seen.Set(other, 1);
      const ClosestPoint closest = ClosestOnTriangle(mesh.TriangleCorners(other), at.position);
      if (closest.distance_squared < radius_m * radius_m) found.push_back(other);
    }
  }
  return found;
}

}  // namespace

bool Remesh(PagedMesh& mesh, const EdgeRange& edges, Region& region, Patch& patch, RemeshCounts& counts) {
  Remesher remesher(mesh, edges, region, counts);
  std::vector<std::uint32_t> too_long, too_short;
  for (const PatchTriangle& t : patch) {
    if (remesher.TooLong(t.triangle)) too_long.push_back(t.triangle);
    if (remesher.TooShort(t.triangle)) too_short.push_back(t.triangle);
  }
  if (too_long.empty() && too_short.empty()) return false;
  for (const std::uint32_t t : too_long) {
    if (remesher.IsMoved(t) && !remesher.SplitUntilShort(t)) break;
  }
  remesher.SplitParts([&](std::uint32_t t) { return remesher.IsMoved(t); });
  for (const std::uint32_t t : too_short) remesher.CollapseShort(t);
  remesher.FlipForValence();
  remesher.SmoothChanged();
  if (remesher.changed().empty()) return false;
  patch = PatchOf(mesh, region);
  return true;
}

void CoarsenStroke(PagedMesh& mesh, double longest_edge_m, Region& region, RemeshCounts& counts) {
  Remesher remesher(mesh, {longest_edge_m, 0}, region, counts);
  std::vector<std::uint32_t> vertices;
  for (std::size_t i = 0; i < region.size(); ++i) vertices.push_back(region.vertex(i));
  vertices.insert(vertices.end(), region.made().begin(), region.made().end());
  // The last made goes first: splits are taken back in the order in which that is possible.
  for (bool again = true; again;) {
    const std::uint32_t before = counts.collapses;
    for (std::size_t i = vertices.size(); i-- > 0;) {
      if (mesh.FirstTriangle(vertices[i]) != kNoIndex) remesher.TakeOut(vertices[i]);
    }
    again = counts.collapses - before > vertices.size() / 50;
  }
}

std::uint32_t RefineBall(PagedMesh& mesh, const SurfacePoint& at, double radius_m, double long_m, Region& region,
                         RemeshCounts& counts) {
  Remesher remesher(mesh, {long_m, 0}, region, counts);
  const auto distance_squared = [&](std::uint32_t t) {
    return ClosestOnTriangle(mesh.TriangleCorners(t), at.position).distance_squared;
  };
  for (const std::uint32_t t : TrianglesInBall(mesh, at, radius_m)) {
    if (!remesher.SplitUntilShort(t)) break;
  }
  remesher.SplitParts(
      [&](std::uint32_t t) { return remesher.TooLong(t) && distance_squared(t) < radius_m * radius_m; });
  return DescendTo(mesh, at.triangle, at.position);  // it is still there, or in one that came off it
}

}  // namespace omni::haptics::sculpt
