// What the tick sees of a sculpted object: one immutable generation of pages and the tree over them.
#pragma once

#include <vector>

#include "service/haptics/sculpt/top_tree.h"

namespace omni::haptics::sculpt {

// One published generation. The editor owns it and its pages until the reader has acknowledged a newer one.
struct SculptTable {
  std::uint64_t generation = 0;  // counts up from 1
  std::vector<const Page*> pages;
  std::vector<TopNode> nodes;  // root first
};

// A view of one generation; valid during the tick that acquired it. Any number may exist, reading takes no lock.
class SculptSurface : public PageView {
 public:
  explicit SculptSurface(const SculptTable& table) noexcept
      : PageView(table.pages.data()),
        nodes_(table.nodes.data()),
        page_count_(static_cast<std::uint32_t>(table.pages.size())),
        generation_(table.generation) {}

  const TopNode& Node(std::uint32_t index) const noexcept { return nodes_[index]; }
  std::uint32_t page_count() const noexcept { return page_count_; }
  std::uint64_t generation() const noexcept { return generation_; }

  // False for a slot that holds no triangle in this generation; any index may be asked for.
  bool IsLive(std::uint32_t triangle) const noexcept {
    return PageOf(triangle) < page_count_ && UsesTriangle(pages_[PageOf(triangle)]->content, SlotOf(triangle));
  }

 private:
  const TopNode* nodes_;
  std::uint32_t page_count_;
  std::uint64_t generation_;
};

}  // namespace omni::haptics::sculpt
