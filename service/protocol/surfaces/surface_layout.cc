#include "service/protocol/surfaces/surface_layout.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "service/protocol/text.h"

namespace omni::protocol {
namespace {

std::string InObject(std::size_t index, const std::string& problem) {
  return "object " + std::to_string(index) + ": " + problem;
}

std::string CountProblem(std::uint64_t count) {
  if (count <= kMaxSurfaceObjects) return {};
  return std::to_string(count) + " objects, the limit is " + std::to_string(kMaxSurfaceObjects);
}

// Checks that both sides apply to the numbers of one object.
std::string CapacityProblem(std::uint32_t flags, std::uint32_t vertices, std::uint32_t triangles) {
  if (flags == 0 || (flags & ~kAllSurfaceFlags) != 0) return "flags " + std::to_string(flags) + " are not known";
  if (vertices > kMaxSurfaceVertices) {
    return std::to_string(vertices) + " vertices, the limit is " + std::to_string(kMaxSurfaceVertices);
  }
  if (triangles > kMaxSurfaceTriangles) {
    return std::to_string(triangles) + " triangles, the limit is " + std::to_string(kMaxSurfaceTriangles);
  }
  if ((vertices == 0) != (triangles == 0)) return "vertices without triangles, or triangles without vertices";
  return {};
}

// True: `count` buffers for `capacity` entries at `offset` lie within [begin, bytes). The limits above keep the sums
// far from overflow.
bool Fits(std::uint64_t offset, std::uint32_t capacity, std::uint32_t count, std::uint64_t begin, std::uint64_t bytes) {
  return offset % 64 == 0 && offset >= begin && offset <= bytes &&
         SurfaceBufferBytes(capacity) * count <= bytes - offset;
}

std::string PartProblem(const SurfacePart& part, std::uint64_t begin, std::uint64_t bytes) {
  if (std::string problem = CapacityProblem(part.flags, part.vertex_capacity, part.triangle_capacity);
      !problem.empty()) {
    return problem;
  }
  if (part.vertex_capacity == 0) return {};
  if (part.triangle_buffers != 1 && part.triangle_buffers != kSurfaceBuffers) {
    return std::to_string(part.triangle_buffers) + " buffers of triangles, must be 1 or 3";
  }
  const bool inside = Fits(part.vertices, part.vertex_capacity, kSurfaceBuffers, begin, bytes) &&
                      Fits(part.triangles, part.triangle_capacity, part.triangle_buffers, begin, bytes);
  return inside ? std::string() : "buffers outside the memory";
}

// The plain fields of an entry, copied as bytes: the memory is another process's.
SurfacePart CopyPart(const std::byte* at) {
  char name[sizeof(SurfaceEntry::name)];
  const auto field = [at](std::size_t offset, auto& value) { std::memcpy(&value, at + offset, sizeof(value)); };
  field(offsetof(SurfaceEntry, name), name);
  SurfacePart part;
  field(offsetof(SurfaceEntry, object), part.object);
  field(offsetof(SurfaceEntry, flags), part.flags);
  field(offsetof(SurfaceEntry, vertex_capacity), part.vertex_capacity);
  field(offsetof(SurfaceEntry, triangle_capacity), part.triangle_capacity);
  field(offsetof(SurfaceEntry, triangle_buffers), part.triangle_buffers);
  field(offsetof(SurfaceEntry, vertices), part.vertices);
  field(offsetof(SurfaceEntry, triangles), part.triangles);
  part.name = Printable(std::string_view(name, ::strnlen(name, sizeof(name))));
  return part;
}

SurfaceLayout Refused(std::string problem) {
  SurfaceLayout layout;
  layout.problem = std::move(problem);
  return layout;
}

}  // namespace

SurfaceLayout LayOutSurfaces(std::span<const SurfacePlan> plans) {
  if (std::string problem = CountProblem(plans.size()); !problem.empty()) return Refused(problem);
  SurfaceLayout layout;
  std::uint64_t end = kSurfaceEntries + (plans.size() * sizeof(SurfaceEntry) + 63) / 64 * 64;
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const SurfacePlan& plan = plans[i];
    std::string problem = CapacityProblem(plan.flags, plan.vertex_capacity, plan.triangle_capacity);
    if (!problem.empty()) return Refused(InObject(i, problem));
    SurfacePart part{.name = plan.name,
                     .object = plan.object,
                     .flags = plan.flags,
                     .vertex_capacity = plan.vertex_capacity,
                     .triangle_capacity = plan.triangle_capacity};
    if (plan.vertex_capacity > 0) {
      part.triangle_buffers = plan.triangles_change ? kSurfaceBuffers : 1;
      part.vertices = end;
      part.triangles = part.vertices + kSurfaceBuffers * SurfaceBufferBytes(plan.vertex_capacity);
      end = part.triangles + part.triangle_buffers * SurfaceBufferBytes(plan.triangle_capacity);
    }
    layout.parts.push_back(std::move(part));
  }
  if (end > kMaxSurfaceBytes) {
    return Refused(std::to_string(end) + " bytes, the limit is " + std::to_string(kMaxSurfaceBytes));
  }
  layout.total_bytes = end;
  return layout;
}

SurfaceLayout CheckSurfaceLayout(const std::byte* memory, std::uint64_t bytes) {
  if (bytes < kSurfaceEntries || bytes > kMaxSurfaceBytes) return Refused("has " + std::to_string(bytes) + " bytes");
  const auto field = [memory](std::size_t offset, auto& value) { std::memcpy(&value, memory + offset, sizeof(value)); };
  std::uint32_t magic = 0, version = 0, object_count = 0, entry_bytes = 0;
  SurfaceLayout layout;
  field(offsetof(SurfaceHeader, magic), magic);
  field(offsetof(SurfaceHeader, version), version);
  field(offsetof(SurfaceHeader, total_bytes), layout.total_bytes);
  field(offsetof(SurfaceHeader, service_instance), layout.service_instance);
  field(offsetof(SurfaceHeader, memory_generation), layout.memory_generation);
  field(offsetof(SurfaceHeader, scene_generation), layout.scene_generation);
  field(offsetof(SurfaceHeader, object_count), object_count);
  field(offsetof(SurfaceHeader, entry_bytes), entry_bytes);
  if (magic != kSurfaceMagic) return Refused("does not begin with the surface memory's magic");
  if (version != kSurfaceVersion || entry_bytes != sizeof(SurfaceEntry)) {
    return Refused("has layout version " + std::to_string(version) + " with entries of " + std::to_string(entry_bytes) +
                   " bytes, this client knows " + std::to_string(kSurfaceVersion) + " with " +
                   std::to_string(sizeof(SurfaceEntry)) + "; install the same Omni version for service and client");
  }
  if (layout.total_bytes != bytes) {
    return Refused("says it has " + std::to_string(layout.total_bytes) + " bytes, it has " + std::to_string(bytes));
  }
  if (layout.memory_generation == 0) return Refused("has memory_generation 0");
  if (std::string problem = CountProblem(object_count); !problem.empty()) return Refused("has " + problem);
  const std::uint64_t begin = kSurfaceEntries + std::uint64_t{object_count} * sizeof(SurfaceEntry);
  if (begin > bytes) return Refused("is too small for its " + std::to_string(object_count) + " objects");
  for (std::uint32_t i = 0; i < object_count; ++i) {
    SurfacePart part = CopyPart(memory + kSurfaceEntries + i * sizeof(SurfaceEntry));
    const std::string problem = PartProblem(part, begin, bytes);
    if (!problem.empty()) return Refused(InObject(i, problem));
    layout.parts.push_back(std::move(part));
  }
  return layout;
}

namespace {

constexpr std::uint64_t kMaxChange = std::uint64_t{1} << 62;

}  // namespace

// Without early exits, so that compilers vectorise it.
bool InRange(std::span<const SurfacePoint> vertices_base_m) noexcept {
  bool good = true;
  for (const SurfacePoint& p : vertices_base_m) {
    for (const float x : p) good &= std::abs(x) <= kMaxSurfaceCoordinate_m;
  }
  return good;
}

bool InRange(std::span<const SurfaceTriangle> triangles, std::uint32_t vertex_count) noexcept {
  bool good = true;
  for (const SurfaceTriangle& t : triangles) {
    for (const std::uint32_t vertex : t) good &= vertex < vertex_count;
  }
  return good;
}

bool InRange(const SurfaceFrame& frame) noexcept {
  double squared = 0;
  for (const double q : frame.rotation_wxyz) squared += q * q;
  bool good = std::abs(squared - 1) <= 1e-2;
  for (const double x : frame.translation_m) good &= std::abs(x) <= double{kMaxSurfaceCoordinate_m};
  good &= frame.largest_displacement_m >= 0 && frame.largest_displacement_m <= 2 * double{kMaxSurfaceCoordinate_m};
  return good && frame.vertex_change <= kMaxChange && frame.triangle_change <= kMaxChange;
}

}  // namespace omni::protocol
