#include "service/haptics/sculpt/mesh/region.h"

#include <limits>

#include "service/haptics/geometry/topology.h"
#include "service/haptics/sculpt/mesh/crossing.h"

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

void Region::AddMiddle(std::uint32_t middle, std::uint32_t a, std::uint32_t b, const Vec3& edge) {
  constexpr double kSteep = 0.7;  // cosine: 45 degrees
  made_.push_back(middle);
  if (IsHeld(a) && IsHeld(b)) Hold(middle);
  const Vec3 move = 0.5 * (MoveOf(a) + MoveOf(b));
  const bool is_wall = (Has(a) || Has(b)) && std::abs(Dot(edge, Normalized(move))) > kSteep * Norm(edge);
  if ((Has(a) && Has(b)) || is_wall) Add(middle, 0.5 * (WeightOf(a) + WeightOf(b)), move);
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

namespace {

// Puts back the corners of what went wrong, until nothing is: at worst all stays as it was.
class Displacement {
 public:
  Displacement(PagedMesh& mesh, Region& region, const Patch& patch, const std::vector<Corners>& before,
               const std::vector<Vec3>& old, std::vector<bool>& stays)
      : mesh_(mesh), region_(region), patch_(patch), before_(before), old_(old), stays_(stays) {}

  std::size_t PutBack() {
    while (TurnedOver() || PassedThrough()) Recheck();
    region_.SetUp(up_);
    return put_back_;
  }

 private:
  bool PutBack(std::uint32_t i) {
    if (i == kNoIndex || stays_[i]) return false;
    stays_[i] = true;
    mesh_.MoveVertex(region_.vertex(i), old_[i]);
    ++put_back_;
    changed_.push_back(i);
    return true;
  }
  bool IsMoved(std::uint32_t i) const { return i != kNoIndex && !stays_[i]; }

  // The triangles at what was put back have another shape now.
  void Recheck() {
    std::vector<bool> put_back(region_.size(), false);
    for (const std::uint32_t i : changed_) put_back[i] = true;
    changed_.clear();
    for (std::size_t n = 0; n < patch_.size(); ++n) {
      for (const std::uint32_t i : patch_[n].at) {
        if (i == kNoIndex || !put_back[i]) continue;
        checked_[n] = passed_[n] = false;
        mesh_.Moved(patch_[n].triangle);
      }
    }
  }

  bool TurnedOver() {
    bool any = false;
    for (std::size_t n = 0; n < patch_.size(); ++n) {
      if (checked_[n]) continue;
      checked_[n] = true;
      if (MayBecome(before_[n], mesh_.TriangleCorners(patch_[n].triangle), 0)) continue;
      for (const std::uint32_t i : patch_[n].at) any |= PutBack(i);
    }
    return any;
  }

  // The moved triangles and all others within their box hang together and face one way, like a field of heights:
  // nothing can have passed through anything [Volino & Magnenat-Thalmann 1994].
  bool IsFieldOfHeights() {
    up_ = {};
    mesh_.FitChangedTrees();
    IndexMap place, field;
    for (std::uint32_t n = 0; n < patch_.size(); ++n) place.Set(patch_[n].triangle, n);
    for (std::uint32_t n = 0; n < patch_.size(); ++n) {
      if (!field.Has(patch_[n].triangle) && !IsFieldOfHeights(n, place, field)) return false;
    }
    return true;
  }

  // The part of the patch that triangle `first` is in, and what it hangs together with: marked by `first` in `field`.
  bool IsFieldOfHeights(std::uint32_t first, const IndexMap& place, IndexMap& field) {
    std::vector<std::uint32_t> found{patch_[first].triangle};
    FloatBox box;
    Vec3 sum;
    const auto add = [&](std::uint32_t triangle) {
      field.Set(triangle, first);
      found.push_back(triangle);
    };
    field.Set(found[0], first);
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Corners corners = mesh_.TriangleCorners(found[i]);
      box.Add(BoxOf(corners));
      box.Add(BoxOf(before_[place.Find(found[i])]));
      sum += AreaVector(corners);
      for (const std::uint32_t t : mesh_.GetTriangle(found[i]).neighbour) {
        if (place.Has(t) && !field.Has(t)) add(t);
      }
    }
    const Vec3 up = Normalized(sum);
    double longest2 = 0;
    for (const std::uint32_t t : found) {
      const Corners corners = mesh_.TriangleCorners(t);
      if (!FacesUp(corners, up)) return false;
      longest2 = std::max(longest2, LongestSquared(corners));
    }
    const auto margin = static_cast<float>(std::sqrt(longest2));  // what remeshing may change around it
    for (float& x : box.lower) x -= margin;
    for (float& x : box.upper) x += margin;
    const bool is_all = found.size() == patch_.size();
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (const std::uint32_t t : mesh_.GetTriangle(found[i]).neighbour) {
        if (field.Has(t)) continue;
        const Corners corners = mesh_.TriangleCorners(t);
        if (BoxesMeet(BoxOf(corners), box) && FacesUp(corners, up)) add(t);
      }
    }
    const bool alone = !VisitNear(mesh_, box, [&](std::uint32_t other) {
      return mesh_.IsLive(other) && field.Find(other) != first && BoxesMeet(BoxOf(mesh_.TriangleCorners(other)), box);
    });
    if (alone && is_all) up_ = up;
    return alone;
  }

  // Where two triangles have come through each other, or a vertex too near to what is not beside it   (4.5).
  bool PassedThrough() {
    if (std::all_of(stays_.begin(), stays_.end(), [](bool stays) { return stays; })) return false;
    if (IsFieldOfHeights()) return false;
    mesh_.FitTrees();
    const std::vector<bool> flat = FlatFans();
    std::vector<std::uint32_t> wrong;  // triangles
    for (std::size_t n = 0; n < patch_.size(); ++n) {
      if (passed_[n]) continue;
      passed_[n] = true;
      const auto& at = patch_[n].at;
      if (!IsMoved(at[0]) && !IsMoved(at[1]) && !IsMoved(at[2])) continue;
      const std::uint32_t triangle = patch_[n].triangle;
      const Triangle& t = mesh_.GetTriangle(triangle);
      const Corners corners = mesh_.TriangleCorners(triangle);
      VisitNear(mesh_, BoxOf(corners), [&](std::uint32_t other) {
        if (other == triangle) return false;
        const Triangle& u = mesh_.GetTriangle(other);
        for (std::size_t k = 0; k < 3; ++k) {
          if (at[k] != kNoIndex && flat[at[k]] && HasVertex(u, t.vertex[k])) return false;
        }
        const bool crosses = TrianglesCross(t, corners, u, mesh_.TriangleCorners(other));
        if (!crosses || TrianglesCross(t, before_[n], u, Before(u))) return false;
        wrong.push_back(triangle);
        wrong.push_back(other);
        return false;
      });
    }
    for (std::uint32_t i = 0; i < region_.size(); ++i) {
      if (!stays_[i]) AddTooNear(i, wrong);
    }
    bool any = false;
    for (const std::uint32_t t : wrong) {
      for (const std::uint32_t v : mesh_.GetTriangle(t).vertex) {
        if (PutBack(region_.Find(v))) region_.Hold(v), any = true;
      }
    }
    return any;
  }

  static bool HasVertex(const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v || t.vertex[1] == v || t.vertex[2] == v;
  }

  // Per vertex of the region: all triangles around it face one way, so that they have no more than it in common.
  std::vector<bool> FlatFans() const {
    std::vector<Vec3> normal(patch_.size()), mean(region_.size());
    for (std::size_t n = 0; n < patch_.size(); ++n) {
      normal[n] = Normalized(AreaVector(mesh_.TriangleCorners(patch_[n].triangle)));
      for (const std::uint32_t i : patch_[n].at) {
        if (i != kNoIndex) mean[i] += normal[n];
      }
    }
    std::vector<bool> flat(region_.size(), true);
    for (std::size_t n = 0; n < patch_.size(); ++n) {
      for (const std::uint32_t i : patch_[n].at) {
        if (i != kNoIndex && !(Dot(normal[n], mean[i]) > 0)) flat[i] = false;
      }
    }
    return flat;
  }

  void AddTooNear(std::uint32_t i, std::vector<std::uint32_t>& wrong) const {
    const std::uint32_t vertex = region_.vertex(i);
    const Vec3 here = mesh_.VertexPosition(vertex), margin{kLeastGap_m, kLeastGap_m, kLeastGap_m};
    VisitNear(mesh_, BoxOf({here - margin, here + margin, here}), [&](std::uint32_t other) {
      const double now = ClosestOnTriangle(mesh_.TriangleCorners(other), here).distance_squared;
      if (!(now < kLeastGap_m * kLeastGap_m) || IsBeside(vertex, other)) return false;
      if (now >= ClosestOnTriangle(Before(mesh_.GetTriangle(other)), old_[i]).distance_squared) return false;
      wrong.push_back(mesh_.FirstTriangle(vertex));
      wrong.push_back(other);
      return false;
    });
  }

  // A corner of the triangle is the vertex or a neighbour of it.
  bool IsBeside(std::uint32_t vertex, std::uint32_t triangle) const {
    const Triangle& t = mesh_.GetTriangle(triangle);
    const std::uint32_t start = mesh_.FirstTriangle(vertex);
    std::uint32_t current = start;
    do {
      const Triangle& around = mesh_.GetTriangle(current);
      for (const std::uint32_t a : around.vertex) {
        if (HasVertex(t, a)) return true;
      }
      current = around.neighbour[CornerOf(around, vertex)];
    } while (current != start);
    return false;
  }

  Corners Before(const Triangle& t) const {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t i = region_.Find(t.vertex[k]);
      corners[k] = i == kNoIndex ? mesh_.VertexPosition(t.vertex[k]) : old_[i];
    }
    return corners;
  }

  PagedMesh& mesh_;
  Region& region_;
  const Patch& patch_;
  const std::vector<Corners>& before_;
  const std::vector<Vec3>& old_;
  std::vector<bool>& stays_;
  std::vector<bool> checked_ = std::vector<bool>(patch_.size(), false);  // that it has not turned over ...
  std::vector<bool> passed_ = checked_;                                  // ... nor passed through
  std::vector<std::uint32_t> changed_;                                   // put back since the last Recheck
  std::size_t put_back_ = 0;
  Vec3 up_;  // Region::up()
};

}  // namespace

std::size_t DisplaceVertices(PagedMesh& mesh, Region& region, const Patch& patch, double offset_m) {
  std::vector<Corners> before;
  before.reserve(patch.size());
  for (const PatchTriangle& t : patch) {
    before.push_back(mesh.TriangleCorners(t.triangle));
    mesh.Moved(t.triangle);
  }
  std::vector<Vec3> old(region.size());
  std::vector<bool> stays(region.size(), false);
  region.SetDirection(offset_m < 0);
  for (std::size_t i = 0; i < region.size(); ++i) {
    old[i] = mesh.VertexPosition(region.vertex(i));
    const Vec3 moved = old[i] + offset_m * region.move(i);
    stays[i] = region.IsHeld(region.vertex(i)) || !IsWithin(moved, kMaxCoordinate_m);
    if (!stays[i]) mesh.MoveVertex(region.vertex(i), moved);
  }
  return Displacement(mesh, region, patch, before, old, stays).PutBack();
}

}  // namespace omni::haptics::sculpt
