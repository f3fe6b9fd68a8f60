// The vertices a stroke moves, how far each goes per metre of offset, and moving them: never through a triangle of
// their own fan. docs/theory/sculpting.md, section 3.
#pragma once

#include "service/haptics/geometry/triangle_math.h"
#include "service/haptics/sculpt/mesh/geodesic.h"
#include "service/haptics/sculpt/stroke.h"

namespace omni::haptics::sculpt {

// What a triangle must keep: area, and the side it faces.
inline constexpr double kLeastShape = 1e-3;  // 2 area / longest edge^2; worse triangles are not made   (4.1)
inline constexpr double kTooShort_m = 5e-6;  // shorter edges are collapsed, and not made

inline double LongestSquared(const Corners& c) noexcept {
  return std::max({SquaredNorm(c[1] - c[0]), SquaredNorm(c[2] - c[1]), SquaredNorm(c[0] - c[2])});
}

inline double ShortestSquared(const Corners& c) noexcept {
  return std::min({SquaredNorm(c[1] - c[0]), SquaredNorm(c[2] - c[1]), SquaredNorm(c[0] - c[2])});
}

// 2 area / longest edge^2: 0.87 equilateral, 0 without area. Not a number for a triangle that is a point.
inline double ShapeOf(const Corners& c) noexcept { return Norm(AreaVector(c)) / LongestSquared(c); }

// May `before` become `after`? It must keep facing the same way (cosine over `least_cosine` >= 0) and not become a
// needle, unless it was a worse one, and no edge may become shorter than kTooShort_m, unless it is the longer one now.
inline bool MayBecome(const Corners& before, const Corners& after, double least_cosine) noexcept {
  const Vec3 old_area = AreaVector(before), new_area = AreaVector(after);
  const double along = Dot(old_area, new_area);
  const double old2 = SquaredNorm(old_area), new2 = SquaredNorm(new_area);
  if (!(along > 0 && along * along > least_cosine * least_cosine * old2 * new2)) return false;
  const double longest2 = LongestSquared(after), shortest2 = ShortestSquared(after);
  if (shortest2 < kTooShort_m * kTooShort_m && shortest2 < ShortestSquared(before)) return false;
  return new2 >= kLeastShape * kLeastShape * longest2 * longest2 || ShapeOf(after) >= ShapeOf(before);
}

inline constexpr std::size_t kMaxRegionVertices = 65536;

class Region {
 public:
  std::size_t size() const noexcept { return vertex_.size(); }
  std::uint32_t vertex(std::size_t i) const noexcept { return vertex_[i]; }
  std::uint32_t Find(std::uint32_t vertex) const noexcept { return place_.Find(vertex); }  // kNoIndex: not in it
  const Vec3& move(std::size_t i) const noexcept { return move_[i]; }
  double weight(std::size_t i) const noexcept { return weight_[i]; }
  bool Has(std::uint32_t vertex) const noexcept { return place_.Has(vertex); }
  // By splits of this stroke, in the region or beyond; some are gone again.
  const std::vector<std::uint32_t>& made() const noexcept { return made_; }
  Vec3 MoveOf(std::uint32_t vertex) const noexcept {
    const std::uint32_t at = place_.Find(vertex);
    return at == kNoIndex ? Vec3{} : move_[at];
  }
  double WeightOf(std::uint32_t vertex) const noexcept {
    const std::uint32_t at = place_.Find(vertex);
    return at == kNoIndex ? 0 : weight_[at];
  }

  // All triangles with a corner in the region, and those around them, face this way (unit) and hang together, and
  // nothing else is near; zero: not known   (4.5).
  const Vec3& up() const noexcept { return up_; }
  void SetUp(const Vec3& up) noexcept { up_ = up; }

  // Vertices that have come to another part of the surface: they stay until the stroke turns back.
  void Hold(std::uint32_t vertex) { held_.Set(vertex, 1); }
  bool IsHeld(std::uint32_t vertex) const noexcept { return held_.Has(vertex); }
  void SetDirection(bool inwards) {
    if (inwards != inwards_) held_ = {};
    inwards_ = inwards;
  }

  // Where two parts overlap, their sum, but never more than one offset.   (3.3)
  void Add(std::uint32_t vertex, double weight, const Vec3& move);
  void Remove(std::uint32_t vertex);
  // A vertex on the middle of an edge moves like the middle, unless the edge leads from the region to what lies beside
  // it: along a wall that the stroke has made it does. `edge`: from a to b.
  void AddMiddle(std::uint32_t middle, std::uint32_t a, std::uint32_t b, const Vec3& edge);

 private:
  std::vector<std::uint32_t> vertex_;
  std::vector<double> weight_;
  std::vector<Vec3> move_;
  std::vector<std::uint32_t> made_;
  Vec3 up_;
  bool inwards_ = false;
  IndexMap place_, held_;
};

// A triangle with a corner in the region; at[k]: place of corner k in the region, kNoIndex: it does not move.
struct PatchTriangle {
  std::uint32_t triangle;
  std::array<std::uint32_t, 3> at;
};
using Patch = std::vector<PatchTriangle>;

// All of them, each once, in an order that depends on the region alone. Good until connections or the region change.
Patch PatchOf(const PagedMesh& mesh, const Region& region);

struct Weighted {
  std::vector<GeodesicVertex> vertices;  // distance_m holds the weight
  Vec3 mean_normal;                      // area- and weight-averaged, unit   (3.2)
  double mean_edge_m = 0;
};

// Weights of the vertices around a point. Empty: the radius holds no vertex, or more than
// kMaxRegionVertices.
Weighted WeighBall(const PagedMesh& mesh, const SurfacePoint& at, const Brush& brush);

// Longest step (m of offset) in which no edge at the region's triangles changes by more than a quarter of itself, so
// that Displace can judge each triangle before and after.   (3.4)
double LongestStep(const PagedMesh& mesh, const Region& region, const Patch& patch);

// p += offset_m * move. Vertices at which a triangle would lose its area, turn over, or come to another part of the
// surface stay where they are. Returns the number of those.
std::size_t DisplaceVertices(PagedMesh& mesh, Region& region, const Patch& patch, double offset_m);

}  // namespace omni::haptics::sculpt
