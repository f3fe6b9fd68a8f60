// The surface as it is now: the rest mesh plus the offsets of its extrude regions. Every reader of vertices in the tick
// goes through here, so that what deforms the surface is known in one place.
#pragma once

#include <array>

#include "service/haptics/geometry/mesh_view.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"

namespace omni::haptics {

class Surface {
 public:
  // Precondition: !scene.empty(); scene outlives the view.
  Surface(const Scene& scene, const std::array<RegionState, kMaxRegions>& states) noexcept
      : vertices_(scene.vertices().data()),
        region_of_(scene.region_of().empty() ? nullptr : scene.region_of().data()),
        triangles_(scene.triangles().data()),
        nodes_(scene.nodes().data()),
        tree_extent_m_(scene.header().tree_extent_m),
        region_count_(std::min(scene.header().region_count, kMaxRegions)) {
    const auto regions = scene.regions();
    for (std::size_t r = 0; r < region_count_; ++r) {
      displacement_[r] = states[r].offset_m * regions[r].normal;
    }
  }

  Vec3 VertexPosition(std::uint32_t index) const noexcept {
    const Vertex& v = vertices_[index];
    const Vec3 rest{v.x, v.y, v.z};
    return region_of_ == nullptr || region_of_[index] == kNoIndex ? rest : rest + displacement_[region_of_[index]];
  }
  Corners TriangleCorners(std::uint32_t index) const noexcept {
    const Triangle& t = triangles_[index];
    return {VertexPosition(t.vertex[0]), VertexPosition(t.vertex[1]), VertexPosition(t.vertex[2])};
  }
  const Triangle& GetTriangle(std::uint32_t index) const noexcept { return triangles_[index]; }
  const TreeNode& Node(std::uint32_t index) const noexcept { return nodes_[index]; }
  LeafCorners RestCorners(const LeafRange& leaf) const noexcept {
    return GatherCorners(
        leaf, [&](std::uint32_t t, std::size_t k) noexcept { return &vertices_[triangles_[t].vertex[k]].x; });
  }
  double TreeExtent() const noexcept { return tree_extent_m_; }
  std::uint32_t region_count() const noexcept { return region_count_; }

  // Region that all three corners move with, else kNoIndex.
  std::uint32_t RegionOf(std::uint32_t triangle) const noexcept {
    if (region_of_ == nullptr) return kNoIndex;
    const Triangle& t = triangles_[triangle];
    const std::uint32_t region = region_of_[t.vertex[0]];
    return region_of_[t.vertex[1]] == region && region_of_[t.vertex[2]] == region ? region : kNoIndex;
  }

 private:
  const Vertex* vertices_;
  const std::uint32_t* region_of_;  // null: there are no regions
  const Triangle* triangles_;
  const TreeNode* nodes_;
  double tree_extent_m_;
  std::uint32_t region_count_;
  std::array<Vec3, kMaxRegions> displacement_{};
};

static_assert(TreeView<Surface>);

}  // namespace omni::haptics
