// Whether a triangle of the surface being edited passes through another part of it. docs/theory/sculpting.md, (4.5).
#pragma once

#include <bit>
#include <vector>

#include "service/haptics/geometry/tree_lanes.h"
#include "service/haptics/sculpt/mesh/paged_mesh.h"

namespace omni::haptics::sculpt {

// No stroke brings two parts of the surface nearer to each other: a reader may weld what is nearer than that.
inline constexpr double kLeastGap_m = 1e-5;

// The triangle faces within 84 degrees of `up`, a unit vector.
inline bool FacesUp(const Corners& corners, const Vec3& up) noexcept {
  constexpr double kLeastCosine = 0.1;
  const Vec3 area = AreaVector(corners);
  return Dot(area, up) > kLeastCosine * Norm(area);
}

// Do two triangles of a surface have a point in common beyond the corners that they share, or fold onto each other?
bool TrianglesCross(const Triangle& t, const Corners& t_corners, const Triangle& u, const Corners& u_corners) noexcept;

// Checks single operations: after each, what it changed is announced.
class CrossingCheck {
 public:
  // `up`: Region::up() of where they are.
  CrossingCheck(PagedMesh& mesh, const Vec3& up) : mesh_(mesh), up_(up) {}

  // The triangle's corners or place have changed. It is live.
  void Changed(std::uint32_t triangle) {
    if (!fitted_) return;  // all will be
    if (changed_.size() >= kMaxChanged) Fit();
    changed_.push_back(triangle);
  }
  // The triangle as it is now passes through another, live one; `without`: those two do not count, `gone`: a vertex
  // that counts as `kept`.
  bool CrossesAnother(std::uint32_t triangle, const std::array<std::uint32_t, 2>& without = {kNoIndex, kNoIndex},
                      std::uint32_t gone = kNoIndex, std::uint32_t kept = kNoIndex);

 private:
  static constexpr std::size_t kMaxChanged = 64;
  void Fit() {
    mesh_.FitTrees();
    changed_.clear();
    fitted_ = true;
  }

  PagedMesh& mesh_;
  const Vec3 up_;
  std::vector<std::uint32_t> changed_;  // since the trees were fitted
  bool fitted_ = false;
};

// Calls visit(triangle) for all whose boxes may meet the box, and a few more, until one returns true; returns whether
// one did. Precondition: the trees are fitted, or what has changed since does not matter.
template <class Visit>
bool VisitNear(const PagedMesh& mesh, const FloatBox& box, const Visit& visit) {
  const SculptSurface surface = mesh.SurfaceNow();
  std::array<std::uint32_t, (kTreeWidth - 1) * kMaxTreeDepth + kTreeWidth> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const TreeNode& node = surface.Node(stack[--size]);
    for (auto meet = static_cast<unsigned>(MeetMask(node, box.lower, box.upper)); meet != 0; meet &= meet - 1) {
      const std::uint32_t child = node.child[std::countr_zero(meet)];
      if ((child & kLeafBit) == 0) {
        stack[size++] = child;
        continue;
      }
      std::array<std::uint32_t, kLeafSize> triangles;
      const int count = surface.LeafTriangles(child & kChildIndex, triangles);
      for (int i = 0; i < count; ++i) {
        if (visit(triangles[static_cast<std::size_t>(i)])) return true;
      }
    }
  }
  return false;
}

}  // namespace omni::haptics::sculpt
