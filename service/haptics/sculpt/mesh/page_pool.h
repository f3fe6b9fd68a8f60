// Pages of one editor: taken, retired while a reader may still see them, and used again.
#pragma once

#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "service/haptics/sculpt/mesh/page.h"

namespace omni::haptics::sculpt {

class PagePool {
 public:
  // Contents undefined.
  Page* Take() {
    if (free_.empty()) Grow();
    Page* page = free_.back();
    free_.pop_back();
    return page;
  }
  // No reader uses it.
  void Give(Page* page) { free_.push_back(page); }
  // Readers of generations before `first_without` may still read it.
  void Retire(Page* page, std::uint64_t first_without) { retired_.push_back({page, first_without}); }
  // Nothing older than `oldest_in_use` is read any longer.
  void Release(std::uint64_t oldest_in_use) {
    while (!retired_.empty() && retired_.front().first_without <= oldest_in_use) {
      Give(retired_.front().page);
      retired_.pop_front();
    }
  }
  std::size_t bytes() const noexcept { return chunks_.size() * kChunk * sizeof(Page); }

 private:
  struct Retired {
    Page* page;
    std::uint64_t first_without;
  };
  static constexpr std::size_t kChunk = 16;

  void Grow() {
    chunks_.push_back(std::make_unique_for_overwrite<Page[]>(kChunk));
    for (std::size_t k = kChunk; k > 0; --k) free_.push_back(&chunks_.back()[k - 1]);
  }

  std::vector<std::unique_ptr<Page[]>> chunks_;
  std::vector<Page*> free_;
  std::deque<Retired> retired_;
};

}  // namespace omni::haptics::sculpt
