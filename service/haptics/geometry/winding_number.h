// How often a mesh winds around a point: 1 inside a closed mesh that faces outwards, 0 outside, in between near holes
// [Jacobson, Kavan & Sorkine-Hornung 2013]. docs/theory/haptics.md (R.5). Set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "service/base/work_watch.h"
#include "service/haptics/geometry/mesh.h"

namespace omni::haptics {

// Signed solid angle of a triangle whose corners are seen from the origin, rad   (R.4)
double SolidAngle(const Vec3& a, const Vec3& b, const Vec3& c);

// Sums over far triangles by their clusters' area vectors [Barill et al. 2018]: O(log n) per point, error about 1 %.
class WindingTree {
 public:
  using Triangles = std::span<const std::array<std::uint32_t, 3>>;

  // What is passed outlives the tree; vertices stay. Precondition: indices in range, vertices finite.
  WindingTree(std::span<const Vec3> vertices, Triangles triangles, const base::WorkWatch& watch = {});
  explicit WindingTree(const Mesh& mesh, const base::WorkWatch& watch = {})
      : WindingTree(mesh.vertices, mesh.triangles, watch) {}

  // After triangles were turned.
  void Refit();

  // At `p`; triangle `own`, on which p lies, does not count: what is then left lies half-way between the two sides.
  double At(const Vec3& p, std::uint32_t own = kNoTriangle) const {
    std::uint64_t visited = 0;
    return At(p, own, visited);
  }
  // `visited` grows by the nodes that were looked at, and twice their triangles: what it costs.
  double At(const Vec3& p, std::uint32_t own, std::uint64_t& visited) const;
  bool IsInside(const Vec3& p) const { return At(p) > 0.5; }

 private:
  static constexpr std::uint32_t kNoTriangle = 0xFFFFFFFF;
  struct Node {
    Vec3 centre;       // of the area
    Vec3 area_vector;  // sum of n A
    double area_m2 = 0;
    double radius_m = 0;                 // no triangle reaches further from the centre
    std::uint32_t first = 0, count = 0;  // of order_
    std::uint32_t left = 0, right = 0;   // 0: leaf (the root is never a child)
  };
  std::uint32_t Build(std::uint32_t first, std::uint32_t count, const std::vector<Vec3>& centroids,
                      const base::WorkWatch& watch);

  void FitLeaf(Node& node) const;

  std::span<const Vec3> vertices_;
  Triangles triangles_;
  std::vector<std::uint32_t> order_;          // of triangles
  std::vector<std::array<Vec3, 3>> corners_;  // in this order: a leaf is read at once
  std::vector<Node> nodes_;
};

}  // namespace omni::haptics
