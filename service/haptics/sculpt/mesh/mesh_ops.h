// Changes of connection on a closed mesh: split, collapse and flip of an edge, each leaving it closed, oriented and
// 2-manifold. Written for PagedMesh; a refused operation changes nothing. docs/theory/sculpting.md, section 4.
#pragma once

#include "service/haptics/sculpt/mesh/paged_mesh.h"

namespace omni::haptics::sculpt {

inline constexpr int kMaxValence = 64;  // vertices with more triangles around them are neither collapsed nor flipped

// Edge k of triangle t, from vertex[k] to vertex[(k + 1) % 3].
struct Edge {
  std::uint32_t triangle;
  std::uint32_t k;
};

// An edge with both its triangles: (a, b, c) holds it as a -> b, (b, a, d) as b -> a.
struct Diamond {
  std::uint32_t t, o;        // the triangles
  std::uint32_t a, b, c, d;  // vertices
  std::uint32_t t_bc, t_ca;  // neighbours of t
  std::uint32_t o_ad, o_db;  // neighbours of o
};
Diamond DiamondOf(const PagedMesh& mesh, const Edge& edge) noexcept;

// Triangles around a vertex, each with the vertex's corner. Empty if there are more than kMaxValence.
class Fan {
 public:
  Fan(const PagedMesh& mesh, std::uint32_t vertex) noexcept;
  int size() const noexcept { return size_; }
  std::uint32_t triangle(int i) const noexcept { return triangle_[static_cast<std::size_t>(i)]; }
  // The vertex after `vertex` in triangle i; over all i these are its neighbours, each once.
  std::uint32_t next(int i) const noexcept { return next_[static_cast<std::size_t>(i)]; }

 private:
  int size_ = 0;
  std::array<std::uint32_t, kMaxValence> triangle_;
  std::array<std::uint32_t, kMaxValence> next_;
};

// From triangle to triangle around, as long as one is nearer to `p`; the nearest of the neighbourhood.
std::uint32_t DescendTo(const PagedMesh& mesh, std::uint32_t triangle, const Vec3& p) noexcept;

// Puts a new vertex at `position` on the edge and returns it; kNoIndex when the mesh is at its largest.
std::uint32_t SplitEdge(PagedMesh& mesh, const Edge& edge, const Vec3& position);

// True if a can be merged into b without a pinch: the two have exactly the two common neighbours c and d, and those
// keep three triangles (4.2).
bool CanCollapse(const Diamond& diamond, const PagedMesh& mesh, const Fan& fan_a, const Fan& fan_b) noexcept;
// Merges a into b, which stays where it is; a and both triangles of the edge are gone. Precondition: CanCollapse.
void CollapseEdge(PagedMesh& mesh, const Diamond& diamond, const Fan& fan_a);

// True if c and d are not connected yet, and a and b keep three triangles.
bool CanFlip(const PagedMesh& mesh, const Diamond& diamond, const Fan& fan_c, int valence_a, int valence_b) noexcept;
// The edge a - b becomes c - d. Precondition: CanFlip.
void FlipEdge(PagedMesh& mesh, const Diamond& diamond);

}  // namespace omni::haptics::sculpt
