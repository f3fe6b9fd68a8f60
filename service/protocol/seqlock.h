// The seqlock of state_memory.h, both sides. One writer, any number of readers; neither side ever waits.
//
// No fences: every shared word is stored with release and loaded with acquire order. A reader that saw a word of a
// newer value has thereby also seen the odd sequence stored before it, so its second read of the sequence differs.
// This work is based on H.-J. Boehm, "Can seqlocks get along with programming language memory models?" (2012).
#pragma once

#include <cstring>

#include "service/protocol/state_memory.h"

namespace omni::protocol {

// Sequence of a cell that holds publication `index` (counted from 0).
constexpr std::uint64_t SequenceOf(std::uint64_t index) noexcept { return 2 * (index + 1); }

// Writer only. `sequence` is even and differs from the cell's present one.
template <class T>
void StoreCell(SeqlockCell<T>& cell, std::uint64_t sequence, const T& value) noexcept {
  std::array<std::uint64_t, SeqlockCell<T>::kWords> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  cell.sequence.store(sequence - 1, std::memory_order_release);
  for (std::size_t i = 0; i < raw.size(); ++i) cell.words[i].store(raw[i], std::memory_order_release);
  cell.sequence.store(sequence, std::memory_order_release);
}

// One attempt to read. Returns the sequence that `value` belongs to; 0: never written, or torn (`value` untouched).
template <class T>
std::uint64_t LoadCell(const SeqlockCell<T>& cell, T& value) noexcept {
  const std::uint64_t sequence = cell.sequence.load(std::memory_order_acquire);
  if (sequence % 2 != 0) return 0;
  std::array<std::uint64_t, SeqlockCell<T>::kWords> raw;
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = cell.words[i].load(std::memory_order_acquire);
  if (sequence == 0 || cell.sequence.load(std::memory_order_acquire) != sequence) return 0;
  std::memcpy(static_cast<void*>(&value), raw.data(), sizeof(T));
  return sequence;
}

}  // namespace omni::protocol
