// Tree over the pages. The editor keeps it up to date along the paths of the pages it changed; a
// copy of its nodes goes out with every published table.
#pragma once

#include <vector>

#include "service/haptics/sculpt/mesh/boxes.h"

namespace omni::haptics::sculpt {

inline constexpr int kMaxTopDepth = 16;            // levels of nodes, kept by TopTree
static_assert(kMaxTopDepth + 2 <= kMaxTreeDepth);  // with those of a page: stacks in the tick are fixed

class TopTree {
 public:
  // One box per page; empty boxes are allowed. Node 0 is the root.
  void Build(const std::vector<FloatBox>& page_boxes);
  // The page's box has changed: fits the boxes above it.
  void SetPageBox(std::uint32_t page, const FloatBox& box);
  // A new page (index = pages so far) beside `near_page`.
  void Insert(std::uint32_t near_page, const FloatBox& box);

  const std::vector<TreeNode>& nodes() const noexcept { return nodes_; }
  std::size_t pages() const noexcept { return place_.size(); }
  FloatBox bounds() const noexcept { return UnionOf(nodes_[0]); }

 private:
  struct Place {
    std::uint32_t node, slot;
  };
  std::uint32_t NewNode(Place parent);
  void Fill(std::uint32_t node, std::uint32_t* begin, std::uint32_t* end, int depth);
  std::vector<std::uint32_t*> SplitInEight(std::uint32_t* begin, std::uint32_t* end) const;
  void Put(Place place, std::uint32_t child, const FloatBox& box);
  int DepthOf(std::uint32_t node) const;

  std::vector<TreeNode> nodes_;
  std::vector<Place> parent_;       // per node; the root's node is kNoIndex
  std::vector<Place> place_;        // per page
  std::vector<FloatBox> page_box_;  // per page
};

}  // namespace omni::haptics::sculpt
