// The trees of a sculpted mesh: one per page and one over the pages, and the float boxes they are made of.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "service/haptics/sculpt/mesh/page.h"

namespace omni::haptics::sculpt {

inline constexpr float kNoBox = 1e30F;  // lower; upper = -kNoBox: nothing is near it, no segment meets it

// Box of float corners; empty: lower > upper.
struct FloatBox {
  std::array<float, 3> lower{kNoBox, kNoBox, kNoBox};
  std::array<float, 3> upper{-kNoBox, -kNoBox, -kNoBox};
  bool empty() const noexcept { return !(lower[0] <= upper[0]); }
  void Add(const FloatBox& other) noexcept {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], other.lower[axis]);
      upper[axis] = std::max(upper[axis], other.upper[axis]);
    }
  }
  friend bool operator==(const FloatBox&, const FloatBox&) = default;
};

inline bool BoxesMeet(const FloatBox& a, const FloatBox& b) noexcept {
  bool meet = true;
  for (std::size_t axis = 0; axis < 3; ++axis)
    meet = meet && a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
  return meet;
}

// Nearest floats are within 2^-24 |x| of x; one step of 2^-23 |x| outwards is at least one float further.
inline float BelowFloat(double x) noexcept {
  const auto f = static_cast<float>(x);
  return f - std::abs(f) * 0x1p-23F - 1e-36F;
}
inline float AboveFloat(double x) noexcept {
  const auto f = static_cast<float>(x);
  return f + std::abs(f) * 0x1p-23F + 1e-36F;
}

inline FloatBox BoxOf(const Corners& c) noexcept {
  const Vec3 lower = Min(Min(c[0], c[1]), c[2]);
  const Vec3 upper = Max(Max(c[0], c[1]), c[2]);
  return {{BelowFloat(lower.x), BelowFloat(lower.y), BelowFloat(lower.z)},
          {AboveFloat(upper.x), AboveFloat(upper.y), AboveFloat(upper.z)}};
}

inline FloatBox GetBox(const TreeNode& boxes, std::size_t k) noexcept {
  return {{boxes.lower[0][k], boxes.lower[1][k], boxes.lower[2][k]},
          {boxes.upper[0][k], boxes.upper[1][k], boxes.upper[2][k]}};
}

inline void SetBox(const FloatBox& box, std::size_t k, TreeNode& boxes) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    boxes.lower[axis][k] = box.lower[axis];
    boxes.upper[axis][k] = box.upper[axis];
  }
}

inline FloatBox UnionOf(const TreeNode& boxes) noexcept {
  FloatBox all;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < 8; ++k) {
      all.lower[axis] = std::min(all.lower[axis], boxes.lower[axis][k]);
      all.upper[axis] = std::max(all.upper[axis], boxes.upper[axis][k]);
    }
  }
  return all;
}

// The tree of one page (page_tree.cc), made on the editor's side before the page is published.

// Fills tree of pages[page] from the page's triangles, whose corners may lie in other pages. `keep_order`: only
// positions have changed since the last call, so the grouping stays and the boxes are refitted.
void BuildPageTree(const Page* const* pages, std::uint32_t page, bool keep_order, PageTree& tree) noexcept;

inline FloatBox BoxOf(const PageTree& tree) noexcept { return UnionOf(tree.top); }

// The tree over the pages (top_tree.cc). The editor keeps it up to date along the paths of the pages it changed; a copy
// of its nodes goes out with every published table.
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
