// The surface memory: a memfd with the surfaces of one scene as they are now, for drawing. Written by omnid's surface
// thread at 90 Hz, mapped read-only by clients that requested it (control.h, SurfaceRequest).
//
//   [SurfaceHeader][SurfaceEntry x object_count][buffers of object 0][buffers of object 1] ...
//
// An object has kSurfaceBuffers buffers of vertices (three floats each, base frame, m) and one of triangles (three
// 32-bit vertex numbers each), or kSurfaceBuffers of those if its triangles change, as those of a sculpted object do.
// Publication n of vertices lies in buffer n % kSurfaceBuffers, and the entry's frame, a seqlock (state_memory.h), says
// which publications are the newest and how much of each buffer counts.
//
// Neither side waits. The writer stores n in `vertices_begun` before the first word of publication n. A reader copies
// the words of publication n, then checks `vertices_begun`: from n + kSurfaceBuffers on, the writer has reused this
// buffer, and the reader takes the newer frame instead. It has two whole periods (22 ms) to copy. Triangles alike.
// Every word is stored with release and loaded with acquire order, as in state_memory.h.
//
// Header and entries are written once, before the memory is shared. What outgrows its capacity, and another scene, gets
// a new memory with a new `memory_generation`. docs/protocol/ipc.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "service/protocol/state_memory.h"

namespace omni::protocol {

inline constexpr std::uint32_t kSurfaceMagic = 0x46534D4F;  // "OMSF"
inline constexpr std::uint32_t kSurfaceVersion = 1;
inline constexpr std::uint32_t kSurfaceBuffers = 3;
inline constexpr std::uint32_t kMaxSurfaceObjects = 64;
inline constexpr std::uint32_t kMaxSurfaceVertices = 1u << 24;   // capacity of one object
inline constexpr std::uint32_t kMaxSurfaceTriangles = 1u << 25;  // likewise
inline constexpr std::uint64_t kMaxSurfaceBytes = 1u << 30;      // of the whole memory
inline constexpr float kMaxSurfaceCoordinate_m = 100;            // |x| of a vertex

// Base frame, m.
using SurfacePoint = std::array<float, 3>;
using SurfaceTriangle = std::array<std::uint32_t, 3>;  // counter-clockwise from outside

// What about an object changes; an object may have several.
enum SurfaceFlag : std::uint32_t {
  kSurfaceSoft = 1u << 0,      // yields under the pen: vertices
  kSurfaceSculpted = 1u << 1,  // vertices and triangles
  kSurfaceExtruded = 1u << 2,  // faces are pulled out and pushed in: vertices
  kSurfaceMoved = 1u << 3  // moved by its application: the frame's pose; vertices, if any, are where the scene has it
};
inline constexpr std::uint32_t kAllSurfaceFlags = kSurfaceSoft | kSurfaceSculpted | kSurfaceExtruded | kSurfaceMoved;

// Of one object, now. A place in the base frame: x = R vertex + translation.
struct SurfaceFrame {
  std::int64_t t_ns = 0;              // CLOCK_MONOTONIC of the Hall sample that this follows from; 0: none yet
  std::uint64_t vertex_change = 0;    // publication of the vertices; 0: the object has none
  std::uint64_t triangle_change = 0;  // of the triangles; also another one when the number of vertices changes
  std::uint32_t vertex_count = 0;
  std::uint32_t triangle_count = 0;
  std::array<double, 4> rotation_wxyz{1, 0, 0, 0};  // unit
  std::array<double, 3> translation_m{};
  double largest_displacement_m = 0;  // of a vertex from where the scene has it, without the pose; sculpted: 0
};
static_assert(std::is_trivially_copyable_v<SurfaceFrame> && sizeof(SurfaceFrame) % 8 == 0);

// Shows that the writer is alive, and how often it polls.
struct SurfacePulse {
  std::int64_t t_ns = 0;         // CLOCK_MONOTONIC of the newest poll
  std::uint64_t poll_count = 0;  // since the memory was made
};
static_assert(std::is_trivially_copyable_v<SurfacePulse> && sizeof(SurfacePulse) % 8 == 0);

struct SurfaceEntry {
  char name[48] = {};                 // the scene's, UTF-8, terminated
  std::uint32_t object = 0;           // its number in the scene
  std::uint32_t flags = 0;            // SurfaceFlag
  std::uint32_t vertex_capacity = 0;  // of each buffer; 0: only a pose
  std::uint32_t triangle_capacity = 0;
  std::uint32_t triangle_buffers = 0;  // 1 or kSurfaceBuffers; 0 without triangles
  std::uint32_t reserved = 0;
  std::uint64_t vertices = 0;  // offset of the first buffer from the start of the memory, a multiple of 64
  std::uint64_t triangles = 0;
  Word vertices_begun{0};
  Word triangles_begun{0};
  SeqlockCell<SurfaceFrame> frame;
};

struct SurfaceHeader {
  std::uint32_t magic = kSurfaceMagic;
  std::uint32_t version = kSurfaceVersion;
  std::uint64_t total_bytes = 0;
  std::uint64_t service_instance = 0;
  std::uint64_t memory_generation = 0;  // counts up from 1 in one instance of the service
  std::uint64_t scene_generation = 0;   // as in the service's status
  std::uint32_t object_count = 0;
  std::uint32_t entry_bytes = sizeof(SurfaceEntry);
  SeqlockCell<SurfacePulse> pulse;
};
static_assert(sizeof(SurfaceEntry) % 8 == 0 && sizeof(SurfaceHeader) % 8 == 0);

}  // namespace omni::protocol
