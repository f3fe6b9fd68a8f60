#include "service/haptics/sculpt/mesh/trees.h"

#include <algorithm>
#include <numeric>

namespace omni::haptics::sculpt {
namespace {

float Middle(const FloatBox& box, std::size_t axis) { return box.empty() ? 0 : box.lower[axis] + box.upper[axis]; }

}  // namespace

std::uint32_t TopTree::NewNode(Place parent) {
  TreeNode node{};
  for (std::size_t k = 0; k < 8; ++k) {
    node.child[k] = kNoChild;
    SetBox(FloatBox{}, k, node);
  }
  nodes_.push_back(node);
  parent_.push_back(parent);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void TopTree::Put(Place place, std::uint32_t child, const FloatBox& box) {
  nodes_[place.node].child[place.slot] = child;
  SetBox(box, place.slot, nodes_[place.node]);
  if ((child & kPageNode) != 0) {
    place_[child & ~kPageNode] = place;
  } else {
    parent_[child] = place;
  }
}

// Three halvings along the longest side of the middles.
std::vector<std::uint32_t*> TopTree::SplitInEight(std::uint32_t* begin, std::uint32_t* end) const {
  std::vector<std::uint32_t*> cuts{begin, end};
  for (int level = 0; level < 3; ++level) {
    std::vector<std::uint32_t*> finer{cuts.front()};
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      std::array<float, 3> lower{kNoBox, kNoBox, kNoBox}, upper{-kNoBox, -kNoBox, -kNoBox};
      for (const std::uint32_t* p = cuts[i]; p < cuts[i + 1]; ++p) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          lower[axis] = std::min(lower[axis], Middle(page_box_[*p], axis));
          upper[axis] = std::max(upper[axis], Middle(page_box_[*p], axis));
        }
      }
      std::size_t longest = 0;
      for (std::size_t axis = 1; axis < 3; ++axis) {
        if (upper[axis] - lower[axis] > upper[longest] - lower[longest]) longest = axis;
      }
      std::uint32_t* middle = cuts[i] + (cuts[i + 1] - cuts[i]) / 2;
      std::nth_element(cuts[i], middle, cuts[i + 1], [&](std::uint32_t a, std::uint32_t b) {
        const float x = Middle(page_box_[a], longest), y = Middle(page_box_[b], longest);
        return x != y ? x < y : a < b;
      });
      finer.push_back(middle);
      finer.push_back(cuts[i + 1]);
    }
    cuts = finer;
  }
  return cuts;
}

// Depth is at most log8(kMaxPages) + 1.
void TopTree::Fill(std::uint32_t node, std::uint32_t* begin, std::uint32_t* end,  // NOLINT(misc-no-recursion)
                   int depth) {
  if (end - begin <= 8) {
    for (std::uint32_t k = 0; begin + k < end; ++k) Put({node, k}, begin[k] | kPageNode, page_box_[begin[k]]);
    return;
  }
  const std::vector<std::uint32_t*> cuts = SplitInEight(begin, end);
  for (std::uint32_t k = 0; k < 8; ++k) {
    const std::uint32_t child = NewNode({node, k});
    Fill(child, cuts[k], cuts[k + 1], depth + 1);
    Put({node, k}, child, UnionOf(nodes_[child]));
  }
}

void TopTree::Build(const std::vector<FloatBox>& page_boxes) {
  nodes_.clear();
  parent_.clear();
  page_box_ = page_boxes;
  place_.assign(page_boxes.size(), {});
  std::vector<std::uint32_t> pages(page_boxes.size());
  std::iota(pages.begin(), pages.end(), 0U);
  Fill(NewNode({kNoIndex, 0}), pages.data(), pages.data() + pages.size(), 0);
}

void TopTree::SetPageBox(std::uint32_t page, const FloatBox& box) {
  page_box_[page] = box;
  Place at = place_[page];
  SetBox(box, at.slot, nodes_[at.node]);
  while (parent_[at.node].node != kNoIndex) {
    const FloatBox all = UnionOf(nodes_[at.node]);
    at = parent_[at.node];
    if (GetBox(nodes_[at.node], at.slot) == all) return;
    SetBox(all, at.slot, nodes_[at.node]);
  }
}

int TopTree::DepthOf(std::uint32_t node) const {
  int depth = 1;
  for (; parent_[node].node != kNoIndex; node = parent_[node].node) ++depth;
  return depth;
}

// A free slot of the near page's node; else the near page's slot becomes a node for both.
void TopTree::Insert(std::uint32_t near_page, const FloatBox& box) {
  const auto page = static_cast<std::uint32_t>(place_.size());
  place_.push_back({});
  page_box_.push_back(box);
  const Place beside = place_[near_page];
  const std::uint32_t* children = nodes_[beside.node].child;
  const auto free_slot = static_cast<std::uint32_t>(std::find(children, children + 8, kNoChild) - children);
  if (free_slot < 8) {
    Put({beside.node, free_slot}, page | kPageNode, box);
  } else if (DepthOf(beside.node) < kMaxTopDepth) {
    const std::uint32_t node = NewNode(beside);
    Put({node, 0}, near_page | kPageNode, page_box_[near_page]);
    Put({node, 1}, page | kPageNode, box);
    Put(beside, node, UnionOf(nodes_[node]));
  } else {
    Build(std::vector<FloatBox>(page_box_));
  }
  SetPageBox(page, box);
}

}  // namespace omni::haptics::sculpt
