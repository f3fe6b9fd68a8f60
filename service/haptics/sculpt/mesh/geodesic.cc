#include "service/haptics/sculpt/mesh/geodesic.h"

#include <algorithm>
#include <limits>
#include <queue>

#include "service/haptics/geometry/topology.h"

namespace omni::haptics::sculpt {
namespace {

// Distance of b, given those of the edge's ends u and v: the source is laid out in the plane of (u, v, b), on the other
// side of the edge; its straight line to b counts where it crosses the edge   (2.1), [Novotni & Klein 2002].
double Unfolded(const Vec3& u, const Vec3& v, const Vec3& b, double from_u_m, double from_v_m) {
  const double ub2 = SquaredNorm(b - u), vb2 = SquaredNorm(b - v), e2 = SquaredNorm(v - u);
  const double around_m = std::min(from_u_m + std::sqrt(ub2), from_v_m + std::sqrt(vb2));
  const double e = std::sqrt(e2);
  if (!(e > 0)) return around_m;
  const double sx = (from_u_m * from_u_m - from_v_m * from_v_m + e2) / (2 * e);
  const double sy = std::sqrt(std::max(0.0, from_u_m * from_u_m - sx * sx));
  const double bx = (ub2 - vb2 + e2) / (2 * e);
  const double by = std::sqrt(std::max(0.0, ub2 - bx * bx));
  if (!(sy + by > 0)) return around_m;
  const double crossing = sx + (bx - sx) * sy / (sy + by);
  if (!(crossing >= 0 && crossing <= e)) return around_m;
  return std::min(around_m, std::hypot(bx - sx, by + sy));
}

class Front {
 public:
  Front(const PagedMesh& mesh, double radius_m, std::size_t most) : mesh_(mesh), radius_m_(radius_m), most_(most) {}

  std::vector<GeodesicVertex> Run(const SurfacePoint& from) {
    // The fans of the three corners see the point straight.
    for (const std::uint32_t corner : mesh_.GetTriangle(from.triangle).vertex) {
      Relax(corner, Norm(mesh_.VertexPosition(corner) - from.position));
    }
    while (!heap_.empty() && result_.size() <= most_) {
      const auto [distance_m, vertex] = heap_.top();
      heap_.pop();
      const std::uint32_t at = place_.Find(vertex);
      if (distance_m != known_[at].distance_m) continue;  // queued again, nearer
      if (!known_[at].settled) result_.push_back({vertex, distance_m});
      known_[at].settled = true;
      Broadcast(vertex, distance_m);
    }
    for (GeodesicVertex& v : result_) v.distance_m = known_[place_.Find(v.vertex)].distance_m;
    std::sort(result_.begin(), result_.end(), [](const GeodesicVertex& a, const GeodesicVertex& b) {
      return a.distance_m != b.distance_m ? a.distance_m < b.distance_m : a.vertex < b.vertex;
    });
    return std::move(result_);
  }

 private:
  struct Known {
    double distance_m;
    bool settled;
  };
  using Entry = std::pair<double, std::uint32_t>;

  // Every edge around the vertex whose other end is known is a pair to unfold the triangles on both its sides from.
  void Broadcast(std::uint32_t vertex, double distance_m) {
    const Vec3& here = mesh_.VertexPosition(vertex);
    const std::uint32_t start = mesh_.FirstTriangle(vertex);
    std::uint32_t current = start;
    do {
      const Triangle& t = mesh_.GetTriangle(current);
      const auto corner = static_cast<std::size_t>(CornerOf(t, vertex));
      const std::uint32_t a = t.vertex[(corner + 1) % 3], b = t.vertex[(corner + 2) % 3];
      const double from_a_m = Distance(a), from_b_m = Distance(b);
      const Vec3 &pa = mesh_.VertexPosition(a), &pb = mesh_.VertexPosition(b);
      // A path over the edge to the other vertex is no shorter than the nearer of the two.
      if (from_a_m > std::min(distance_m, from_b_m)) {
        Relax(a, from_b_m < kFar ? Unfolded(here, pb, pa, distance_m, from_b_m) : distance_m + Norm(pa - here));
      }
      if (from_b_m > std::min(distance_m, from_a_m)) {
        Relax(b, from_a_m < kFar ? Unfolded(here, pa, pb, distance_m, from_a_m) : distance_m + Norm(pb - here));
      }
      current = t.neighbour[corner];
    } while (current != start);
  }

  double Distance(std::uint32_t vertex) const {
    const std::uint32_t at = place_.Find(vertex);
    return at == kNoIndex ? kFar : known_[at].distance_m;
  }

  void Relax(std::uint32_t vertex, double distance_m) {
    if (!(distance_m < radius_m_)) return;
    const std::uint32_t at = place_.Find(vertex);
    if (at == kNoIndex) {
      place_.Set(vertex, static_cast<std::uint32_t>(known_.size()));
      known_.push_back({distance_m, false});
    } else if (distance_m < known_[at].distance_m * (1 - kNearer)) {
      known_[at].distance_m = distance_m;
    } else {
      return;
    }
    heap_.push({distance_m, vertex});
  }

  static constexpr double kFar = std::numeric_limits<double>::infinity();
  static constexpr double kNearer = 1e-9;  // relative; smaller improvements are rounding
  const PagedMesh& mesh_;
  double radius_m_;
  std::size_t most_;
  IndexMap place_;
  std::vector<Known> known_;
  std::vector<GeodesicVertex> result_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> heap_;
};

}  // namespace

std::vector<GeodesicVertex> GeodesicBall(const PagedMesh& mesh, const SurfacePoint& from, double radius_m,
                                         std::size_t most) {
  return Front(mesh, radius_m, most).Run(from);
}

}  // namespace omni::haptics::sculpt
