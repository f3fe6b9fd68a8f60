// Hands generations of a sculpted surface from the editor to two readers: the tick, and a drawing thread.
//
// The tick never waits and never frees: it loads one pointer and records which generation it now holds. Memory of older
// generations is reused only after that. The drawing thread pins a generation while it copies it and then unpins it: a
// hazard pointer [Michael 2004], which needs no set-up on the editor's thread and costs the editor one load. It loads
// the newest, records the pin, and checks that this still is the newest. Either the editor sees the pin when it checks
// what may be reused, or the reader sees that there is a newer one.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics::sculpt {

// Generations that readers may still hold; beyond, edits accumulate until a later publish.
inline constexpr std::size_t kMaxTables = 4;

class SculptPublisher {
 public:
  // Reader only, at the start of a tick: the newest generation, valid until the next call. Null: none published yet.
  const SculptTable* Acquire() noexcept {
    const SculptTable* table = current_.load(std::memory_order_acquire);
    if (table != nullptr) acknowledged_.store(table->generation, std::memory_order_release);
    return table;
  }

  // Drawing thread only (one): the newest generation, valid until Unpin. Null: none published yet. Not while another
  // one is pinned.
  const SculptTable* Pin() noexcept {
    const SculptTable* table = current_.load(std::memory_order_seq_cst);
    for (;;) {
      pinned_.store(table, std::memory_order_seq_cst);
      const SculptTable* newest = current_.load(std::memory_order_seq_cst);
      if (newest == table) return table;
      table = newest;
    }
  }
  void Unpin() noexcept { pinned_.store(nullptr, std::memory_order_release); }

  // Editor only. False while nothing reads (before the tick starts, after its thread has ended): all but the newest
  // generation is then free at once. Precondition for false: the reader no longer calls Acquire.
  void SetReader(bool present) noexcept {
    if (present && !reader_) acknowledged_.store(0, std::memory_order_relaxed);
    reader_ = present;
  }

  // Editor only: nothing older than this generation is read any more.
  std::uint64_t OldestInUse() const noexcept {
    const std::uint64_t in_tick = reader_ ? acknowledged_.load(std::memory_order_acquire) : generation_;
    const SculptTable* pinned = pinned_.load(std::memory_order_seq_cst);
    return pinned != nullptr ? std::min(in_tick, pinned->generation) : in_tick;
  }
  // A table without readers, to be filled; null: a reader is kMaxTables generations behind.
  SculptTable* SpareTable() {
    const SculptTable* newest = current_.load(std::memory_order_relaxed);
    for (const std::unique_ptr<SculptTable>& table : tables_) {
      if (table.get() != newest && table->generation < OldestInUse()) return table.get();
    }
    if (tables_.size() == kMaxTables) return nullptr;
    tables_.push_back(std::make_unique<SculptTable>());
    return tables_.back().get();
  }
  // Makes it the newest generation; visible to the next Acquire.
  void Publish(SculptTable* table) noexcept {
    table->generation = ++generation_;
    current_.store(table, std::memory_order_seq_cst);
  }
  std::uint64_t generation() const noexcept { return generation_; }
  // The newest, for the editor's own queries; null: none yet.
  const SculptTable* newest() const noexcept { return current_.load(std::memory_order_relaxed); }

 private:
  std::atomic<const SculptTable*> current_{nullptr};
  std::atomic<const SculptTable*> pinned_{nullptr};
  std::atomic<std::uint64_t> acknowledged_{0};
  std::uint64_t generation_ = 0;
  bool reader_ = false;
  std::vector<std::unique_ptr<SculptTable>> tables_;
};

}  // namespace omni::haptics::sculpt
