// What the tick sees of a sculpted object: one immutable generation of pages and the tree over them.
#pragma once

#include <array>
#include <vector>

#include "service/haptics/geometry/mesh_view.h"
#include "service/haptics/sculpt/mesh/trees.h"

namespace omni::haptics::sculpt {

// One published generation. The editor owns it and its pages until the reader has acknowledged a newer one.
struct SculptTable {
  std::uint64_t generation = 0;  // counts up from 1
  std::vector<const Page*> pages;
  std::vector<TreeNode> nodes;  // over the pages, root first
  double extent_m = 0;          // largest |coordinate|
};

// A view of one generation, a TreeView with its root at 0; valid during the tick that acquired it. Any number may
// exist, reading takes no lock.
class SculptSurface : public PageView {
 public:
  explicit SculptSurface(const SculptTable& table) noexcept
      : PageView(table.pages.data()),
        nodes_(table.nodes.data()),
        extent_m_(table.extent_m),
        page_count_(static_cast<std::uint32_t>(table.pages.size())),
        generation_(table.generation) {}

  // Pages and nodes that may still change.
  SculptSurface(const Page* const* pages, std::uint32_t page_count, const TreeNode* nodes) noexcept
      : PageView(pages), nodes_(nodes), extent_m_(kMaxCoordinate_m), page_count_(page_count), generation_(0) {}

  const TreeNode& Node(std::uint32_t index) const noexcept {
    if ((index & kPageNode) != 0) return GetPage(index & ~kPageNode).tree.top;
    if ((index & kGroupNode) != 0) return GetPage((index & ~kGroupNode) >> 3).tree.group[index & 7];
    return nodes_[index];
  }
  // Triangles of a leaf (child & kChildIndex); how many.
  int LeafTriangles(std::uint32_t leaf, std::array<std::uint32_t, kLeafSize>& triangles) const noexcept {
    const std::uint32_t page = leaf >> 6, group = leaf & 63;
    const PageTree& tree = GetPage(page).tree;
    const std::uint32_t begin = tree.GroupBegin(group), end = tree.GroupBegin(group + 1);
    for (std::uint32_t i = begin; i < end; ++i) triangles[i - begin] = IndexOf(page, tree.order[i]);
    return static_cast<int>(end - begin);
  }
  double TreeExtent() const noexcept { return extent_m_; }
  std::uint32_t page_count() const noexcept { return page_count_; }
  std::uint64_t generation() const noexcept { return generation_; }

  // False for a slot that holds no triangle in this generation; any index may be passed.
  bool IsLive(std::uint32_t triangle) const noexcept {
    return PageOf(triangle) < page_count_ && UsesTriangle(pages_[PageOf(triangle)]->content, SlotOf(triangle));
  }

 private:
  const TreeNode* nodes_;
  double extent_m_;
  std::uint32_t page_count_;
  std::uint64_t generation_;
};

static_assert(TreeView<SculptSurface>);

}  // namespace omni::haptics::sculpt
