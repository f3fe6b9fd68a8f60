#include "service/ipc/surface_publisher.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_layout.h"
#include "service/protocol/text.h"

namespace omni::ipc {

using protocol::SurfaceEntry;
using protocol::SurfaceFrame;
using protocol::SurfaceHeader;
using protocol::SurfacePart;
using protocol::Word;

base::Result<std::unique_ptr<SurfacePublisher>> SurfacePublisher::Create(const SurfaceMemoryId& id,
                                                                         std::span<const protocol::SurfacePlan> plans) {
  protocol::SurfaceLayout layout = protocol::LayOutSurfaces(plans);
  if (!layout.problem.empty()) return base::Error{"surfaces to draw: " + layout.problem + "; make the mesh coarser"};
  if (id.memory_generation == 0) return base::Error{"surfaces to draw: memory_generation is 0, must count from 1"};
  auto made =
      base::MakeSealedMemory("omni-surfaces", layout.total_bytes, PROT_READ | PROT_WRITE, base::kSealsOneWriter);
  if (!made) return base::Error{made.error()};
  return std::unique_ptr<SurfacePublisher>(new SurfacePublisher(std::move(*made), id, std::move(layout)));
}

SurfacePublisher::SurfacePublisher(base::SealedMemory memory_file, const SurfaceMemoryId& id,
                                   protocol::SurfaceLayout layout)
    : memory_file_(std::move(memory_file)),
      id_(id),
      layout_(std::move(layout)),
      newest_(layout_.parts.size()),
      published_(layout_.parts.size()) {
  auto* header = new (at(0)) SurfaceHeader;
  header->total_bytes = layout_.total_bytes;
  header->service_instance = id.service_instance;
  header->memory_generation = id.memory_generation;
  header->scene_generation = id.scene_generation;
  header->object_count = static_cast<std::uint32_t>(layout_.parts.size());
  for (std::size_t i = 0; i < layout_.parts.size(); ++i) {
    const SurfacePart& part = layout_.parts[i];
    auto* entry = new (at(protocol::kSurfaceEntries + i * sizeof(SurfaceEntry))) SurfaceEntry;
    protocol::SetField(entry->name, part.name);
    entry->object = part.object;
    entry->flags = part.flags;
    entry->vertex_capacity = part.vertex_capacity;
    entry->triangle_capacity = part.triangle_capacity;
    entry->triangle_buffers = part.triangle_buffers;
    entry->vertices = part.vertices;
    entry->triangles = part.triangles;
  }
}

std::byte* SurfacePublisher::at(std::uint64_t offset) const noexcept {
  return static_cast<std::byte*>(memory_file_.mapping.get()) + offset;
}

SurfaceEntry& SurfacePublisher::Entry(std::size_t index) const noexcept {
  return *reinterpret_cast<SurfaceEntry*>(at(protocol::kSurfaceEntries + index * sizeof(SurfaceEntry)));
}

SurfacePublish SurfacePublisher::Publish(std::size_t index, const SurfaceUpdate& update) noexcept {
  const SurfacePart& part = layout_.parts[index];
  SurfaceFrame frame = newest_[index];
  frame.t_ns = update.t_ns;
  frame.rotation_wxyz = update.rotation_wxyz;
  frame.translation_m = update.translation_m;
  frame.largest_displacement_m = update.largest_displacement_m;
  if (update.vertices_base_m) {
    if (update.vertices_base_m->size() > part.vertex_capacity) return SurfacePublish::kTooLarge;
    frame.vertex_count = static_cast<std::uint32_t>(update.vertices_base_m->size());
    ++frame.vertex_change;
    if (!protocol::InRange(*update.vertices_base_m)) return SurfacePublish::kRefused;
  }
  if (update.triangles) {
    if (update.triangles->size() > part.triangle_capacity) return SurfacePublish::kTooLarge;
    if (part.triangle_buffers == 1 && frame.triangle_change > 0) return SurfacePublish::kRefused;
    frame.triangle_count = static_cast<std::uint32_t>(update.triangles->size());
    ++frame.triangle_change;
    if (!protocol::InRange(*update.triangles, frame.vertex_count)) return SurfacePublish::kRefused;
  }
  const bool other_count = frame.vertex_count != newest_[index].vertex_count;
  if (other_count && !update.triangles) return SurfacePublish::kRefused;  // the old triangles name other vertices
  if (!protocol::InRange(frame)) return SurfacePublish::kRefused;

  SurfaceEntry& entry = Entry(index);
  if (update.vertices_base_m) {
    entry.vertices_begun.store(frame.vertex_change, std::memory_order_release);
    const std::uint64_t buffer = frame.vertex_change % protocol::kSurfaceBuffers;
    std::byte* to = at(part.vertices + buffer * protocol::SurfaceBufferBytes(part.vertex_capacity));
    protocol::StoreWords(reinterpret_cast<Word*>(to), *update.vertices_base_m);
  }
  if (update.triangles) {
    entry.triangles_begun.store(frame.triangle_change, std::memory_order_release);
    const std::uint64_t buffer = frame.triangle_change % part.triangle_buffers;
    std::byte* to = at(part.triangles + buffer * protocol::SurfaceBufferBytes(part.triangle_capacity));
    protocol::StoreWords(reinterpret_cast<Word*>(to), *update.triangles);
  }
  protocol::StoreCell(entry.frame, protocol::SequenceOf(published_[index]++), frame);
  newest_[index] = frame;
  return SurfacePublish::kDone;
}

void SurfacePublisher::PublishPulse(std::int64_t t_ns) noexcept {
  auto* header = reinterpret_cast<SurfaceHeader*>(at(0));
  protocol::StoreCell(header->pulse, protocol::SequenceOf(poll_count_), {.t_ns = t_ns, .poll_count = poll_count_ + 1});
  ++poll_count_;
}

}  // namespace omni::ipc
