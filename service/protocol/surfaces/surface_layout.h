// Where the parts of a surface memory lie, and whether received bytes are a valid one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "service/protocol/surfaces/surface_memory.h"

namespace omni::protocol {

// What the memory is to hold of one object.
struct SurfacePlan {
  std::string name;
  std::uint32_t object = 0;
  std::uint32_t flags = 0;  // SurfaceFlag
  std::uint32_t vertex_capacity = 0;
  std::uint32_t triangle_capacity = 0;
  bool triangles_change = false;
};

// One object's part, with offsets from the memory's start in bytes.
struct SurfacePart {
  std::string name;  // printable
  std::uint32_t object = 0;
  std::uint32_t flags = 0;
  std::uint32_t vertex_capacity = 0;
  std::uint32_t triangle_capacity = 0;
  std::uint32_t triangle_buffers = 0;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

struct SurfaceLayout {
  std::string problem;  // not empty: the rest is not to be used
  std::uint64_t total_bytes = 0;
  std::uint64_t service_instance = 0;
  std::uint64_t memory_generation = 0;
  std::uint64_t scene_generation = 0;
  std::vector<SurfacePart> parts;
};

// Bytes of one buffer of `count` vertices or triangles: each buffer begins at a multiple of 64.
constexpr std::uint64_t SurfaceBufferBytes(std::uint32_t count) noexcept {
  return (std::uint64_t{count} * sizeof(SurfacePoint) + 63) / 64 * 64;
}
static_assert(sizeof(SurfacePoint) == sizeof(SurfaceTriangle));

// A problem names the exceeded limit.
SurfaceLayout LayOutSurfaces(std::span<const SurfacePlan> plans);

// Reads header and entries of `bytes` bytes at `memory` once, into a copy, and checks every number of it against
// `bytes`. Later changes of the memory do not affect the result.
SurfaceLayout CheckSurfaceLayout(const std::byte* memory, std::uint64_t bytes);

// The entries, behind the header.
inline constexpr std::uint64_t kSurfaceEntries = (sizeof(SurfaceHeader) + 63) / 64 * 64;

// The range of what a surface memory may say. The writer publishes nothing else, the reader accepts nothing else.

// Every coordinate a number within +-kMaxSurfaceCoordinate_m.
bool InRange(std::span<const SurfacePoint> vertices_base_m) noexcept;
// Every corner below `vertex_count`.
bool InRange(std::span<const SurfaceTriangle> triangles, std::uint32_t vertex_count) noexcept;
// A rotation (|q|^2 within 1e-2 of 1), a translation within +-kMaxSurfaceCoordinate_m, a displacement >= 0, and
// publications that no writer exceeds. Counts are the caller's to check against its capacities.
bool InRange(const SurfaceFrame& frame) noexcept;

// Vertices and triangles of a surface memory, word by word: see surface_memory.h for the order of things.

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
