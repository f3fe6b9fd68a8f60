// Read-only view of a surface memory (protocol/surfaces/surface_memory.h): surfaces that deform, are sculpted, extruded
// or moved, for drawing. No system call after construction; any number of threads may read, each into a copy of its
// own. Whatever the memory holds, a read ends after a bounded number of steps, stays within the mapping and yields only
// what is in range (protocol/surfaces/surface_layout.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/sealed_memory.h"
#include "service/base/unique_fd.h"
#include "service/protocol/surfaces/surface_layout.h"

namespace omni::client {

// An object as it was last read; kept by the caller and handed in again, so that only what is new is copied.
struct SurfaceCopy {
  protocol::SurfaceFrame frame;
  std::vector<protocol::SurfacePoint> vertices_base_m;  // frame.vertex_count of them, without the frame's pose
  std::vector<protocol::SurfaceTriangle> triangles;
  std::uint64_t reader = 0;  // that filled it; another one refills it from scratch
  // Work buffers of the reader: a torn read never shows.
  std::vector<protocol::SurfacePoint> next_vertices_base_m;
  std::vector<protocol::SurfaceTriangle> next_triangles;
};

enum class SurfaceRead {
  kUnchanged,
  kPose,       // pose or time, not the vertices
  kVertices,   // vertices, perhaps also the pose
  kTriangles,  // vertices and triangles
  kNothing     // nothing published yet, torn kMaxTornReads times, or not in range; the copy is as it was
};

class SurfaceReader {
 public:
  // Checks seals (base::kSealsOneWriter), size and layout before anything is read. The error begins with "surface
  // memory". Never null.
  static base::Result<std::shared_ptr<const SurfaceReader>> Map(base::UniqueFd fd, std::uint64_t announced_bytes);
  SurfaceReader(const SurfaceReader&) = delete;
  SurfaceReader& operator=(const SurfaceReader&) = delete;

  std::size_t object_count() const noexcept { return layout_.parts.size(); }
  // Name, flags (protocol::SurfaceFlag) and number in the scene. Precondition: `object` < object_count().
  const protocol::SurfacePart& object(std::size_t object) const noexcept { return layout_.parts[object]; }
  std::uint64_t memory_generation() const noexcept { return layout_.memory_generation; }
  std::uint64_t scene_generation() const noexcept { return layout_.scene_generation; }
  std::uint64_t service_instance() const noexcept { return layout_.service_instance; }
  std::uint64_t bytes() const noexcept { return layout_.total_bytes; }

  // The newest of an object. The first read into a copy takes memory for the object's capacity, and may throw
  // std::bad_alloc; later ones do not. Precondition: `object` < object_count().
  SurfaceRead Read(std::size_t object, SurfaceCopy& copy) const;

  // False: the writer has not polled yet, or torn kMaxTornReads times.
  bool ReadPulse(protocol::SurfacePulse& pulse) const noexcept;

 private:
  SurfaceReader(base::Mapping mapping, std::uint64_t bytes);
  const protocol::SurfaceEntry& Entry(std::size_t object) const noexcept;
  SurfaceRead TryRead(std::size_t object, SurfaceCopy& copy) const noexcept;
  // Into the work buffers. False: torn or out of range.
  bool ReadVertices(std::size_t object, const protocol::SurfaceFrame& frame, SurfaceCopy& copy) const noexcept;
  bool ReadTriangles(std::size_t object, const protocol::SurfaceFrame& frame, SurfaceCopy& copy) const noexcept;

  base::Mapping mapping_;
  const std::byte* memory_;
  protocol::SurfaceLayout layout_;  // checked copy: the memory's own words are not read again
  const std::uint64_t id_;          // of this reader, unique in the process
};

}  // namespace omni::client
