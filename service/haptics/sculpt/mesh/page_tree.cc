#include "service/haptics/sculpt/mesh/trees.h"

#include <algorithm>
#include <bit>

namespace omni::haptics::sculpt {
namespace {

// Boxes of a page's triangles, in the order they come in, and their slots.
struct SlotBoxes {
  std::uint32_t count = 0;
  std::uint8_t slot[kPageTriangles];
  FloatBox box[kPageTriangles];
};

// abcdefgh -> a00b00c00d00e00f00g00h
constexpr std::uint32_t Spread3(std::uint32_t x) noexcept {
  x = (x | x << 8) & 0x00F00F;
  x = (x | x << 4) & 0x0C30C3;
  return (x | x << 2) & 0x249249;
}

// Sorts along a space-filling curve through the middles of the boxes, 2^8 cells a side: 24 bits of key over 8 bits of
// position, three passes of eight bits   [Morton 1966; Karras, Maximizing Parallelism in the Construction of BVHs,
// 2012].
void SortAlongCurve(const SlotBoxes& boxes, std::uint8_t* order) noexcept {
  FloatBox middles;
  for (std::uint32_t i = 0; i < boxes.count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float twice = boxes.box[i].lower[axis] + boxes.box[i].upper[axis];
      middles.lower[axis] = std::min(middles.lower[axis], twice);
      middles.upper[axis] = std::max(middles.upper[axis], twice);
    }
  }
  std::uint32_t keys[kPageTriangles], sorted[kPageTriangles];
  for (std::uint32_t i = 0; i < boxes.count; ++i) {
    std::uint32_t key = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float twice = boxes.box[i].lower[axis] + boxes.box[i].upper[axis];
      const float extent = middles.upper[axis] - middles.lower[axis];
      const float cell = extent > 0 ? 255 * ((twice - middles.lower[axis]) / extent) : 0;
      key |= Spread3(static_cast<std::uint32_t>(cell)) << axis;
    }
    keys[i] = key << 8 | i;
  }
  for (int shift = 8; shift < 32; shift += 8) {
    std::uint32_t begin[257] = {};
    for (std::uint32_t i = 0; i < boxes.count; ++i) ++begin[(keys[i] >> shift & 255) + 1];
    for (std::size_t k = 1; k < 256; ++k) begin[k] += begin[k - 1];
    for (std::uint32_t i = 0; i < boxes.count; ++i) sorted[begin[keys[i] >> shift & 255]++] = keys[i];
    std::copy(sorted, sorted + boxes.count, keys);
  }
  for (std::uint32_t i = 0; i < boxes.count; ++i) order[i] = boxes.slot[keys[i] & 255];
}

void FitBoxes(const SlotBoxes& boxes, const std::uint8_t* place, std::uint32_t page, PageTree& tree) noexcept {
  for (std::uint32_t k = 0; k < 8; ++k) {
    FloatBox whole;
    for (std::uint32_t j = 0; j < 8; ++j) {
      FloatBox part;
      for (std::uint32_t i = tree.GroupBegin(8 * k + j); i < tree.GroupBegin(8 * k + j + 1); ++i) {
        part.Add(boxes.box[place[tree.order[i]]]);
      }
      SetBox(part, j, tree.group[k]);
      tree.group[k].child[j] = LeafOf(page, 8 * k + j);
      whole.Add(part);
    }
    SetBox(whole, k, tree.top);
    tree.top.child[k] = kGroupNode | page << 3 | k;
  }
}

}  // namespace

void BuildPageTree(const Page* const* pages, std::uint32_t page, bool keep_order, PageTree& tree) noexcept {
  const PageView view(pages);
  const PageContent& content = pages[page]->content;
  SlotBoxes boxes;                     // NOLINT(cppcoreguidelines-pro-type-member-init): filled where used
  std::uint8_t place[kPageTriangles];  // in `boxes`, per slot
  for (std::uint32_t word = 0; word < kPageTriangles / 64; ++word) {
    for (std::uint64_t bits = content.triangle_used[word]; bits != 0; bits &= bits - 1) {
      const auto slot = static_cast<std::uint32_t>(64 * word + std::countr_zero(bits));
      boxes.slot[boxes.count] = static_cast<std::uint8_t>(slot);
      place[slot] = static_cast<std::uint8_t>(boxes.count);
      boxes.box[boxes.count++] = BoxOf(view.TriangleCorners(IndexOf(page, slot)));
    }
  }
  tree.count = boxes.count;
  if (!keep_order) SortAlongCurve(boxes, tree.order);
  FitBoxes(boxes, place, page, tree);
}

const Page& EmptyPage() noexcept {
  static const Page kEmpty = [] {
    Page page{};
    for (Triangle& t : page.content.triangle) {
      t = {};
      for (std::size_t k = 0; k < 3; ++k) t.vertex[k] = t.neighbour[k] = kNoIndex;
    }
    for (std::uint32_t& first : page.content.first_triangle) first = kNoIndex;
    page.content.spill = kNoIndex;
    for (std::size_t k = 0; k < 8; ++k) {
      SetBox(FloatBox{}, k, page.tree.top);
      for (TreeNode& group : page.tree.group) SetBox(FloatBox{}, k, group);
    }
    return page;
  }();
  return kEmpty;
}

}  // namespace omni::haptics::sculpt
