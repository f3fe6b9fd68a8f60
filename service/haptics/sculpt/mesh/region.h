// The vertices a stroke moves, and how far each goes per metre of offset. docs/theory/sculpting.md, section 3.
#pragma once

#include "service/haptics/sculpt/brush.h"
#include "service/haptics/sculpt/mesh/geodesic.h"
#include "service/haptics/sculpt/mesh/index_map.h"

namespace omni::haptics::sculpt {

inline constexpr std::size_t kMaxRegionVertices = 65536;

class Region {
 public:
  std::size_t size() const noexcept { return vertex_.size(); }
  std::uint32_t vertex(std::size_t i) const noexcept { return vertex_[i]; }
  std::uint32_t Find(std::uint32_t vertex) const noexcept { return place_.Find(vertex); }  // kNoIndex: not in it
  const Vec3& move(std::size_t i) const noexcept { return move_[i]; }
  double weight(std::size_t i) const noexcept { return weight_[i]; }
  bool Has(std::uint32_t vertex) const noexcept { return place_.Has(vertex); }
  Vec3 MoveOf(std::uint32_t vertex) const noexcept {
    const std::uint32_t at = place_.Find(vertex);
    return at == kNoIndex ? Vec3{} : move_[at];
  }
  double WeightOf(std::uint32_t vertex) const noexcept {
    const std::uint32_t at = place_.Find(vertex);
    return at == kNoIndex ? 0 : weight_[at];
  }

  // Where two parts overlap, their sum, but never more than one offset.   (3.3)
  void Add(std::uint32_t vertex, double weight, const Vec3& move);
  void Remove(std::uint32_t vertex);
  // A vertex on the middle of an edge moves like the middle.
  void AddMiddle(std::uint32_t middle, std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> vertex_;
  std::vector<double> weight_;
  std::vector<Vec3> move_;
  IndexMap place_;
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

}  // namespace omni::haptics::sculpt
