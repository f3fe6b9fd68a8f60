// Hands generations of a sculpted surface from the editor to one reader (the tick). The reader never waits and never
// frees: it loads one pointer and says which generation it now holds. What an older generation refers to is used again
// only after that.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics::sculpt {

// Generations the reader has not yet passed; beyond, edits collect and go out with a later publish.
inline constexpr std::size_t kMaxTables = 4;

class SculptPublisher {
 public:
  // Reader only, at the start of a tick: the newest generation, valid until the next call. Null: none published yet.
  const SculptTable* Acquire() noexcept {
    const SculptTable* table = current_.load(std::memory_order_acquire);
    if (table != nullptr) acknowledged_.store(table->generation, std::memory_order_release);
    return table;
  }

  // Editor only. False while nothing reads (before the tick starts, after its thread has ended): all but the newest
  // generation is then free at once. Precondition for false: the reader calls Acquire no more.
  void SetReader(bool present) noexcept {
    if (present && !reader_) acknowledged_.store(0, std::memory_order_relaxed);
    reader_ = present;
  }

  // Editor only: nothing older than this generation is read any more.
  std::uint64_t OldestInUse() const noexcept {
    return reader_ ? acknowledged_.load(std::memory_order_acquire) : generation_;
  }
  // A table that nobody reads, to be filled; null: the reader is kMaxTables generations behind.
  SculptTable* Spare();
  // Makes it the newest generation; visible to the next Acquire.
  void Publish(SculptTable* table) noexcept {
    table->generation = ++generation_;
    current_.store(table, std::memory_order_release);
  }
  std::uint64_t generation() const noexcept { return generation_; }
  // The newest, for the editor's own questions; null: none yet.
  const SculptTable* newest() const noexcept { return current_.load(std::memory_order_relaxed); }

 private:
  std::atomic<const SculptTable*> current_{nullptr};
  std::atomic<std::uint64_t> acknowledged_{0};
  std::uint64_t generation_ = 0;
  bool reader_ = false;
  std::vector<std::unique_ptr<SculptTable>> tables_;
};

}  // namespace omni::haptics::sculpt
