// A mesh that is no scene: loose triangles whose numbers do not begin at zero, and a tree over them. Shows that queries
// need nothing of a mesh beyond the concept.
#pragma once

#include <vector>

#include "service/haptics/geometry/query_in_tree.h"
#include "service/haptics/geometry/tree.h"

namespace omni::haptics {

class Soup {
 public:
  struct Record {
    std::uint32_t vertex[3];
    std::uint32_t neighbour[3] = {kNoIndex, kNoIndex, kNoIndex};
    std::uint32_t component = 0;
  };

  explicit Soup(const std::vector<Corners>& corners) {
    std::vector<TreePrimitive> primitives;
    for (std::uint32_t i = 0; i < corners.size(); ++i) {
      records_.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
      primitives.push_back(MakePrimitive(corners[i], i, false));
      for (const Vec3& v : corners[i]) extent_m_ = std::max(extent_m_, 1.001 * LargestComponent(v));
    }
    tree = AppendTree(primitives, NumberOf(0), nodes);
    for (const TreePrimitive& p : primitives) corners_.push_back(corners[p.triangle]);
  }

  static std::uint32_t NumberOf(std::uint32_t i) { return i + 7; }
  static std::uint32_t PlaceOf(std::uint32_t number) { return number - 7; }

  Vec3 VertexPosition(std::uint32_t index) const noexcept { return corners_[index / 3][index % 3]; }
  Corners TriangleCorners(std::uint32_t t) const noexcept { return corners_[PlaceOf(t)]; }
  const Record& GetTriangle(std::uint32_t t) const noexcept { return records_[PlaceOf(t)]; }
  const TreeNode& Node(std::uint32_t index) const noexcept { return nodes[index]; }
  LeafCorners RestCorners(const LeafRange& leaf) const noexcept {
    return GatherCorners(leaf, [&](std::uint32_t t, std::size_t k) { return &corners_[PlaceOf(t)][k].x; });
  }
  double TreeExtent() const noexcept { return extent_m_; }

  std::size_t size() const { return corners_.size(); }
  std::vector<LeafRange> Leaves() const {
    std::vector<LeafRange> leaves;
    for (const TreeNode& node : nodes) {
      for (const std::uint32_t child : node.child) {
        if (child != kNoChild && (child & kLeafBit) != 0) leaves.push_back(LeafRange::Of(child));
      }
    }
    return leaves;
  }

  BuiltTree tree;
  std::vector<TreeNode> nodes;

 private:
  std::vector<Corners> corners_;
  std::vector<Record> records_;
  double extent_m_ = 0;
};
static_assert(TreeView<Soup>);

}  // namespace omni::haptics
