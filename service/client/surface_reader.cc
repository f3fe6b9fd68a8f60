#include "service/client/surface_reader.h"

#include <sys/mman.h>

#include <atomic>
#include <utility>

#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_layout.h"

namespace omni::client {

using protocol::SurfaceEntry;
using protocol::SurfaceFrame;
using protocol::SurfacePart;
using protocol::Word;

namespace {

std::uint64_t NextReaderId() noexcept {
  static std::atomic<std::uint64_t> newest{0};
  return newest.fetch_add(1, std::memory_order_relaxed) + 1;
}

// True: the words of publication `change`, just copied, were not being overwritten.   (surface_memory.h)
bool StillWhole(const Word& begun, std::uint64_t change, std::uint32_t buffers) noexcept {
  const std::uint64_t newest = begun.load(std::memory_order_acquire);
  return newest >= change && newest - change < buffers;
}

}  // namespace

base::Result<std::shared_ptr<const SurfaceReader>> SurfaceReader::Map(base::UniqueFd fd,
                                                                      std::uint64_t announced_bytes) {
  const auto refuse = [](const std::string& problem) { return base::Error{"surface memory " + problem}; };
  if (announced_bytes < protocol::kSurfaceEntries || announced_bytes > protocol::kMaxSurfaceBytes) {
    return refuse("of " + std::to_string(announced_bytes) + " bytes was announced, must be " +
                  std::to_string(protocol::kSurfaceEntries) + " to " + std::to_string(protocol::kMaxSurfaceBytes));
  }
  auto mapping = base::MapSealed(fd.get(), base::kSealsOneWriter, announced_bytes, PROT_READ);
  if (!mapping.ok()) return refuse(mapping.error());
  std::shared_ptr<const SurfaceReader> reader(new SurfaceReader(std::move(*mapping), announced_bytes));
  if (!reader->layout_.problem.empty()) return refuse(reader->layout_.problem);
  return reader;
}

SurfaceReader::SurfaceReader(base::Mapping mapping, std::uint64_t bytes)
    : mapping_(std::move(mapping)),
      memory_(static_cast<const std::byte*>(mapping_.get())),
      layout_(protocol::CheckSurfaceLayout(memory_, bytes)),
      id_(NextReaderId()) {}

const SurfaceEntry& SurfaceReader::Entry(std::size_t object) const noexcept {
  return *reinterpret_cast<const SurfaceEntry*>(memory_ + protocol::kSurfaceEntries + object * sizeof(SurfaceEntry));
}

SurfaceRead SurfaceReader::Read(std::size_t object, SurfaceCopy& copy) const {
  const SurfacePart& part = layout_.parts[object];
  for (auto* room : {&copy.vertices_base_m, &copy.next_vertices_base_m}) room->reserve(part.vertex_capacity);
  for (auto* room : {&copy.triangles, &copy.next_triangles}) room->reserve(part.triangle_capacity);
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    const SurfaceRead read = TryRead(object, copy);
    if (read != SurfaceRead::kNothing) return read;
  }
  return SurfaceRead::kNothing;
}

SurfaceRead SurfaceReader::TryRead(std::size_t object, SurfaceCopy& copy) const noexcept {
  SurfaceFrame frame;
  if (protocol::LoadCell(Entry(object).frame, frame) == 0 || !protocol::InRange(frame)) return SurfaceRead::kNothing;
  const SurfacePart& part = layout_.parts[object];
  if (frame.vertex_count > part.vertex_capacity || frame.triangle_count > part.triangle_capacity) {
    return SurfaceRead::kNothing;
  }
  const bool known = copy.reader == id_;
  const bool new_triangles = !known || frame.triangle_change != copy.frame.triangle_change;
  const bool new_vertices = !known || new_triangles || frame.vertex_change != copy.frame.vertex_change;
  // The triangles that are kept name vertices of the number there was.
  if (!new_triangles &&
      (frame.vertex_count != copy.frame.vertex_count || frame.triangle_count != copy.frame.triangle_count)) {
    return SurfaceRead::kNothing;
  }
  if (new_vertices && !ReadVertices(object, frame, copy)) return SurfaceRead::kNothing;
  if (new_triangles && !ReadTriangles(object, frame, copy)) return SurfaceRead::kNothing;
  if (new_vertices) copy.vertices_base_m.swap(copy.next_vertices_base_m);
  if (new_triangles) copy.triangles.swap(copy.next_triangles);
  const SurfaceFrame before = std::exchange(copy.frame, frame);
  copy.reader = id_;
  if (new_vertices && part.vertex_capacity > 0) return new_triangles ? SurfaceRead::kTriangles : SurfaceRead::kVertices;
  const bool same_pose = before.t_ns == frame.t_ns && before.rotation_wxyz == frame.rotation_wxyz &&
                         before.translation_m == frame.translation_m;
  return known && same_pose ? SurfaceRead::kUnchanged : SurfaceRead::kPose;
}

bool SurfaceReader::ReadVertices(std::size_t object, const SurfaceFrame& frame, SurfaceCopy& copy) const noexcept {
  const SurfacePart& part = layout_.parts[object];
  copy.next_vertices_base_m.resize(frame.vertex_count);  // within what Read has reserved
  if (frame.vertex_count == 0) return true;
  const std::uint64_t buffer = frame.vertex_change % protocol::kSurfaceBuffers;
  const std::byte* from = memory_ + part.vertices + buffer * protocol::SurfaceBufferBytes(part.vertex_capacity);
  const std::span to(copy.next_vertices_base_m);
  protocol::LoadWords(reinterpret_cast<const Word*>(from), to);
  return StillWhole(Entry(object).vertices_begun, frame.vertex_change, protocol::kSurfaceBuffers) &&
         protocol::InRange(to);
}

bool SurfaceReader::ReadTriangles(std::size_t object, const SurfaceFrame& frame, SurfaceCopy& copy) const noexcept {
  const SurfacePart& part = layout_.parts[object];
  copy.next_triangles.resize(frame.triangle_count);
  if (frame.triangle_count == 0) return true;
  const std::uint64_t buffer = frame.triangle_change % part.triangle_buffers;
  const std::byte* from = memory_ + part.triangles + buffer * protocol::SurfaceBufferBytes(part.triangle_capacity);
  const std::span to(copy.next_triangles);
  protocol::LoadWords(reinterpret_cast<const Word*>(from), to);
  return StillWhole(Entry(object).triangles_begun, frame.triangle_change, part.triangle_buffers) &&
         protocol::InRange(to, frame.vertex_count);
}

bool SurfaceReader::ReadPulse(protocol::SurfacePulse& pulse) const noexcept {
  const auto& header = *reinterpret_cast<const protocol::SurfaceHeader*>(memory_);
  for (int attempt = 0; attempt < protocol::kMaxTornReads; ++attempt) {
    if (protocol::LoadCell(header.pulse, pulse) != 0) return true;
  }
  return false;
}

}  // namespace omni::client
