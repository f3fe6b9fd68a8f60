#include "service/scene/build_estimate.h"

#include <algorithm>

#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/tags/relief_image.h"

namespace omni::scene {
namespace {

constexpr std::uint64_t kFixed = 256 << 10;            // headers, small blocks of the heap
constexpr std::uint64_t kPerNode = 2048;               // its transform, tags and line of explanation
constexpr std::uint64_t kPerPrimitive = 512;           // its accessors and tag
constexpr std::uint64_t kBoxes = 16;                   // of the tree, for each triangle: a node of 224 bytes has 14
constexpr std::uint64_t kSoftKept = 6 << 20;           // a soft body of 2,000 tetrahedra ...
constexpr std::uint64_t kSoftPeak = 60 << 20;          // ... while it is computed, one at a time
constexpr std::uint64_t kSculptKeptPerTriangle = 400;  // pages, not full, and the edges of strokes

// Bytes of a vertex and of a triangle while an object is connected and laid out.
constexpr std::uint64_t kPeakPerVertex = 110, kPeakPerTriangle = 100;

std::uint64_t UvBytes(std::uint64_t uv_triangles) { return uv_triangles * sizeof(haptics::CornerUv); }

}  // namespace

BuildEstimate EstimateBuild(const SceneCounts& counts) {
  BuildEstimate estimate;
  std::uint64_t scene = 0, built = 0, input = 0, soft = 0, sculpted = 0, live_peak = 0;
  for (const ObjectCounts& object : counts.objects) {
    const std::uint64_t triangles = haptics::MostTriangles(object.triangles);
    const std::uint64_t uv = object.triangles == 0 ? 0 : object.uv_triangles * triangles / object.triangles;
    scene += sizeof(haptics::Object) + object.vertices * (sizeof(haptics::Vertex) + sizeof(std::uint32_t)) +
             triangles * (sizeof(haptics::Triangle) + kBoxes) + UvBytes(uv);
    if (object.car_wall) scene += triangles * (sizeof(haptics::WallSegment) + sizeof(haptics::WallNode));
    built += object.vertices * kPeakPerVertex + triangles * kPeakPerTriangle + 3 * UvBytes(uv);
    input += object.vertices * sizeof(base::Vec3) + object.triangles * 14 + UvBytes(object.uv_triangles);
    const std::uint64_t mesh = object.vertices * sizeof(base::Vec3) + triangles * 32;
    if (object.soft) soft += kSoftKept + 2 * mesh;
    if (object.soft) live_peak = std::max(live_peak, kSoftPeak + 2 * mesh);
    if (object.sculpted) sculpted += triangles * kSculptKeptPerTriangle;
    if (object.sculpted) live_peak = std::max(live_peak, triangles * kSculptKeptPerTriangle + 4 * mesh);
  }
  // Parsing takes 12 bytes for each object and array, whose value takes 24; and one long text five times, in a buffer
  // that doubles.
  const std::uint64_t parsed = 5 * counts.json_bytes + counts.document_bytes * 3 / 2;
  if (counts.objects.empty()) {
    estimate.peak_bytes = kFixed + parsed + counts.nodes * kPerNode;
    return estimate;
  }
  scene += kFixed + counts.texels + std::min<std::uint64_t>(counts.primitives, UINT16_MAX) * sizeof(haptics::Material);
  estimate.kept_bytes = scene + soft + sculpted;
  const std::uint64_t document = parsed + counts.nodes * kPerNode + counts.primitives * kPerPrimitive;
  const std::uint64_t decoded = counts.mesh_vertices * sizeof(base::Vec3) + counts.mesh_triangles * 16 +
                                UvBytes(counts.mesh_uv_triangles) + counts.texels;
  const std::uint64_t reading = 2 * counts.mesh_bytes + counts.image_bytes + 3 * counts.largest_image_samples +
                                2 * decoded + (counts.any_relief ? kReliefWorkBytes : 0);
  estimate.peak_bytes = kFixed + document + std::max({reading, decoded + input, built});
  estimate.peak_bytes = std::max(estimate.peak_bytes, estimate.kept_bytes + live_peak);
  return estimate;
}

}  // namespace omni::scene
