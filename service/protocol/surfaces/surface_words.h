// Vertices and triangles of a surface memory, word by word: see surface_memory.h for the order of things.
#pragma once

#include <cstring>
#include <span>

#include "service/protocol/surfaces/surface_memory.h"

namespace omni::protocol {

// Writer only. T: 12 bytes. `to` has room for `from`, rounded up to 8 bytes.
template <class T>
void StoreWords(Word* to, std::span<const T> from) noexcept {
  const auto* bytes = reinterpret_cast<const char*>(from.data());
  const std::size_t whole = from.size_bytes() / sizeof(std::uint64_t);
  for (std::size_t i = 0; i < whole; ++i) {
    std::uint64_t raw;
    std::memcpy(&raw, bytes + i * sizeof(raw), sizeof(raw));
    to[i].store(raw, std::memory_order_release);
  }
  if (const std::size_t rest = from.size_bytes() % sizeof(std::uint64_t); rest != 0) {
    std::uint64_t raw = 0;
    std::memcpy(&raw, bytes + whole * sizeof(raw), rest);
    to[whole].store(raw, std::memory_order_release);
  }
}

template <class T>
void LoadWords(const Word* from, std::span<T> to) noexcept {
  auto* bytes = reinterpret_cast<char*>(to.data());
  const std::size_t whole = to.size_bytes() / sizeof(std::uint64_t);
  for (std::size_t i = 0; i < whole; ++i) {
    const std::uint64_t raw = from[i].load(std::memory_order_acquire);
    std::memcpy(bytes + i * sizeof(raw), &raw, sizeof(raw));
  }
  if (const std::size_t rest = to.size_bytes() % sizeof(std::uint64_t); rest != 0) {
    const std::uint64_t raw = from[whole].load(std::memory_order_acquire);
    std::memcpy(bytes + whole * sizeof(raw), &raw, rest);
  }
}

}  // namespace omni::protocol
