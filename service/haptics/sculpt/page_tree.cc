#include "service/haptics/sculpt/page_tree.h"

#include <algorithm>
#include <bit>

namespace omni::haptics::sculpt {
namespace {

// Boxes of a page's triangles by slot, and the middle of each.
struct SlotBoxes {
  FloatBox box[kPageTriangles];
  float middle[3][kPageTriangles];
};

// Halves ranges at the median of their longest side until there are kGroups. Non-negative floats sort like their bits;
// the slot in the low bits makes every key different, so the result is the same everywhere.
class GroupSorter {
 public:
  GroupSorter(const SlotBoxes& boxes, PageTree& tree) noexcept : boxes_(boxes), tree_(tree) {}

  void Sort(std::uint32_t first_group, std::uint32_t last_group) noexcept {  // NOLINT(misc-no-recursion): 6 deep
    if (last_group - first_group < 2) return;
    const std::uint32_t middle_group = (first_group + last_group) / 2;
    const std::uint32_t begin = tree_.GroupBegin(first_group), end = tree_.GroupBegin(last_group);
    const std::uint32_t middle = tree_.GroupBegin(middle_group);
    if (end - begin < 2) return;
    FillKeys(begin, end);
    std::nth_element(keys_ + begin, keys_ + middle, keys_ + end);
    for (std::uint32_t i = begin; i < end; ++i) tree_.order[i] = static_cast<std::uint8_t>(keys_[i] & 255);
    Sort(first_group, middle_group);
    Sort(middle_group, last_group);
  }

 private:
  void FillKeys(std::uint32_t begin, std::uint32_t end) noexcept {
    std::array<float, 3> lower{kNoBox, kNoBox, kNoBox}, upper{-kNoBox, -kNoBox, -kNoBox};
    for (std::uint32_t i = begin; i < end; ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lower[axis] = std::min(lower[axis], boxes_.middle[axis][tree_.order[i]]);
        upper[axis] = std::max(upper[axis], boxes_.middle[axis][tree_.order[i]]);
      }
    }
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (upper[axis] - lower[axis] > upper[longest] - lower[longest]) longest = axis;
    }
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint8_t slot = tree_.order[i];
      const float along = boxes_.middle[longest][slot] - lower[longest] + 0.0F;
      keys_[i] = std::uint64_t{std::bit_cast<std::uint32_t>(along)} << 8 | slot;
    }
  }

  const SlotBoxes& boxes_;
  PageTree& tree_;
  std::uint64_t keys_[kPageTriangles];
};

void FitBoxes(const SlotBoxes& boxes, PageTree& tree) noexcept {
  for (std::uint32_t k = 0; k < 8; ++k) {
    FloatBox whole;
    for (std::uint32_t j = 0; j < 8; ++j) {
      FloatBox part;
      for (std::uint32_t i = tree.GroupBegin(8 * k + j); i < tree.GroupBegin(8 * k + j + 1); ++i) {
        part.Add(boxes.box[tree.order[i]]);
      }
      SetBox(part, j, tree.group[k]);
      whole.Add(part);
    }
    SetBox(whole, k, tree.top);
  }
}

}  // namespace

void BuildPageTree(const Page* const* pages, std::uint32_t page, bool keep_order, PageTree& tree) noexcept {
  const PageView view(pages);
  const PageContent& content = pages[page]->content;
  SlotBoxes boxes;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled where used
  std::uint32_t count = 0;
  for (std::uint32_t word = 0; word < kPageTriangles / 64; ++word) {
    for (std::uint64_t bits = content.triangle_used[word]; bits != 0; bits &= bits - 1) {
      const auto slot = static_cast<std::uint32_t>(64 * word + std::countr_zero(bits));
      const FloatBox box = BoxOf(view.TriangleCorners(IndexOf(page, slot)));
      boxes.box[slot] = box;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        boxes.middle[axis][slot] = 0.5F * (box.lower[axis] + box.upper[axis]);
      }
      if (!keep_order) tree.order[count] = static_cast<std::uint8_t>(slot);
      ++count;
    }
  }
  tree.count = count;
  if (!keep_order) GroupSorter(boxes, tree).Sort(0, kGroups);
  FitBoxes(boxes, tree);
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
      for (Boxes8& group : page.tree.group) SetBox(FloatBox{}, k, group);
    }
    return page;
  }();
  return kEmpty;
}

}  // namespace omni::haptics::sculpt
