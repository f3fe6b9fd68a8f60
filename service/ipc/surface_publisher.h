// Writer of one surface memory (protocol/surfaces/surface_memory.h). Created and written by one thread, never the
// tick's; the descriptor may be passed on by another.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "service/base/result.h"
#include "service/base/sealed_memory.h"
#include "service/protocol/surfaces/surface_layout.h"

namespace omni::ipc {

struct SurfaceMemoryId {
  std::uint64_t service_instance = 0;
  std::uint64_t memory_generation = 0;  // not 0, never the same twice in one instance
  std::uint64_t scene_generation = 0;
};

// Changes of an object. Omitted vertices and triangles stay as they are.
struct SurfaceUpdate {
  std::int64_t t_ns = 0;  // of the Hall sample that it follows from
  std::optional<std::span<const protocol::SurfacePoint>> vertices_base_m;
  std::optional<std::span<const protocol::SurfaceTriangle>> triangles;
  std::array<double, 4> rotation_wxyz{1, 0, 0, 0};  // unit
  std::array<double, 3> translation_m{};            // base frame
  double largest_displacement_m = 0;
};

enum class SurfacePublish {
  kDone,
  kTooLarge,  // more vertices or triangles than the memory holds: make a new one
  kRefused    // a number that is not finite or out of range, a triangle of no vertex, or triangles that must not change
};

class SurfacePublisher {
 public:
  // Makes the memfd, maps it for writing, then seals it FUTURE_WRITE | SHRINK | GROW | SEAL. The error names the limit
  // that the plans exceed, or the failed system call.
  static base::Result<std::unique_ptr<SurfacePublisher>> Create(const SurfaceMemoryId& id,
                                                                std::span<const protocol::SurfacePlan> plans);
  SurfacePublisher(const SurfacePublisher&) = delete;
  SurfacePublisher& operator=(const SurfacePublisher&) = delete;

  // `index`: of the plan. Readers see all of it or nothing; kTooLarge and kRefused change nothing.
  SurfacePublish Publish(std::size_t index, const SurfaceUpdate& update) noexcept;

  // Call after each poll of the scene, whether something has changed or not.
  void PublishPulse(std::int64_t t_ns) noexcept;

  int fd() const noexcept { return memory_file_.fd.get(); }  // to be passed to clients; stays ours
  std::uint64_t bytes() const noexcept { return layout_.total_bytes; }
  const SurfaceMemoryId& id() const noexcept { return id_; }
  std::size_t object_count() const noexcept { return layout_.parts.size(); }

 private:
  SurfacePublisher(base::SealedMemory memory_file, const SurfaceMemoryId& id, protocol::SurfaceLayout layout);
  std::byte* at(std::uint64_t offset) const noexcept;
  protocol::SurfaceEntry& Entry(std::size_t index) const noexcept;

  base::SealedMemory memory_file_;
  SurfaceMemoryId id_;
  protocol::SurfaceLayout layout_;
  std::vector<protocol::SurfaceFrame> newest_;  // of each object
  std::vector<std::uint64_t> published_;        // frames of each object
  std::uint64_t poll_count_ = 0;
};

}  // namespace omni::ipc
