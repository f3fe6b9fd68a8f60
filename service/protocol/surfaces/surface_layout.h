// Where the parts of a surface memory lie, and whether received bytes are a valid one.
#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace omni::protocol
