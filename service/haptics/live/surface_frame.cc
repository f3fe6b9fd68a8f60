#include "service/haptics/live/surface_frame.h"
#include "service/haptics/deformable/soft_contact.h"
#include "service/haptics/scene/scene.h"

#include <algorithm>

namespace omni::haptics {
namespace {

DrawnVertex Rounded(const Vec3& p) noexcept {
  return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
}

// The object's soft body as it is touched now; null: at rest, or of an object without one.
const SoftContactState* SoftTouchOf(std::uint32_t object, std::span<const SoftTouch> soft) noexcept {
  for (const SoftTouch& touch : soft) {
    if (touch.object == object) return &touch.body;
  }
  return nullptr;
}

// False: the body is not displaced now, or does not belong to this mesh.
bool SoftDisplacements(const Scene& scene, std::span<const SoftTouch> soft, RestObject& rest) {
  const SoftContactState* touch = SoftTouchOf(rest.object, soft);
  const SoftBody* body = scene.live() == nullptr ? nullptr : scene.live()->soft_body(rest.object);
  if (touch == nullptr || body == nullptr) return false;
  rest.displacement_m.resize(rest.vertices_base_m.size());
  return SurfaceDisplacement(body->view(), *touch, rest.vertices_base_m, rest.displacement_m);
}

// Calls with the number of each slot whose bit is set.
template <class Call>
void ForEachSet(std::span<const std::uint64_t> words, std::uint32_t slots, const Call& call) {
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    if ((words[slot / 64] >> (slot % 64) & 1) != 0) call(slot);
  }
}

}  // namespace

std::vector<ChangingObject> ChangingObjects(const Scene& scene) {
  std::vector<ChangingObject> changing;
  if (scene.empty()) return changing;
  const LiveParts* live = scene.live().get();
  for (std::uint32_t o = 0; o < scene.objects().size(); ++o) {
    if (scene.objects()[o].triangle_count == 0) continue;
    const auto in_object = [o](const Region& region) { return region.object == o; };
    ChangingObject found{.object = o};
    found.soft = live != nullptr && live->soft_body(o) != nullptr;
    found.sculpted = live != nullptr && live->sculpt_session(o) != nullptr;
    found.extruded = std::any_of(scene.regions().begin(), scene.regions().end(), in_object);
    found.moved = (scene.objects()[o].flags & kKinematic) != 0;
    if (found.HasVertices() || found.moved) changing.push_back(found);
  }
  return changing;
}

VertexRange VerticesOf(const Scene& scene, std::uint32_t object) noexcept {
  const Object& o = scene.objects()[object];
  std::uint32_t first = kNoIndex, last = 0;
  for (const Triangle& t : scene.triangles().subspan(o.first_triangle, o.triangle_count)) {
    for (const std::uint32_t v : t.vertex) {
      first = std::min(first, v);
      last = std::max(last, v);
    }
  }
  return o.triangle_count == 0 ? VertexRange{} : VertexRange{first, last - first + 1};
}

void DrawnTriangles(const Scene& scene, std::uint32_t object, std::vector<DrawnTriangle>& triangles) {
  const Object& o = scene.objects()[object];
  const std::uint32_t first = VerticesOf(scene, object).first;
  triangles.clear();
  triangles.reserve(o.triangle_count);
  for (const Triangle& t : scene.triangles().subspan(o.first_triangle, o.triangle_count)) {
    triangles.push_back({t.vertex[0] - first, t.vertex[1] - first, t.vertex[2] - first});
  }
}

RestObject RestOf(const Scene& scene, std::uint32_t object) {
  RestObject rest{.object = object, .range = VerticesOf(scene, object)};
  rest.vertices_base_m.reserve(rest.range.count);
  for (const Vertex& v : scene.vertices().subspan(rest.range.first, rest.range.count)) {
    rest.vertices_base_m.push_back({v.x, v.y, v.z});
  }
  return rest;
}

double DisplacedVertices(const Scene& scene, const DeformingState& state, RestObject& rest,
                         std::vector<DrawnVertex>& out) {
  std::array<Vec3, kMaxRegions> offset_m{};
  const std::size_t regions = std::min(scene.regions().size(), state.regions.size());
  for (std::size_t r = 0; r < regions; ++r) offset_m[r] = state.regions[r].offset_m * scene.regions()[r].normal;
  const bool soft = SoftDisplacements(scene, state.soft, rest);
  const auto region_of = scene.region_of();
  double largest_squared_m2 = 0;
  out.resize(rest.range.count);
  for (std::size_t v = 0; v < out.size(); ++v) {
    const std::uint32_t region = region_of.empty() ? kNoIndex : region_of[rest.range.first + v];
    Vec3 moved = region < regions ? offset_m[region] : Vec3{};
    if (soft) {
      const Float3& d = rest.displacement_m[v];
      moved = moved + Vec3{double{d.x}, double{d.y}, double{d.z}};
    }
    largest_squared_m2 = std::max(largest_squared_m2, SquaredNorm(moved));
    out[v] = Rounded(rest.vertices_base_m[v] + moved);
  }
  return std::sqrt(largest_squared_m2);
}

void CompactSurface(const sculpt::SculptTable& table, std::vector<DrawnVertex>& vertices,
                    std::vector<DrawnTriangle>& triangles) {
  vertices.clear();
  triangles.clear();
  // Number of each vertex slot, page by page: slots that are not used are named by no triangle.
  std::vector<std::uint32_t> number(table.pages.size() * sculpt::kPageVertices);
  for (std::size_t page = 0; page < table.pages.size(); ++page) {
    const sculpt::PageContent& content = table.pages[page]->content;
    ForEachSet(content.vertex_used, sculpt::kPageVertices, [&](std::uint32_t slot) {
      number[page * sculpt::kPageVertices + slot] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(Rounded(content.vertex[slot]));
    });
  }
  const auto number_of = [&number](std::uint32_t vertex) {
    return number[std::size_t{sculpt::PageOf(vertex)} * sculpt::kPageVertices + sculpt::SlotOf(vertex)];
  };
  for (const sculpt::Page* page : table.pages) {
    ForEachSet(page->content.triangle_used, sculpt::kPageTriangles, [&](std::uint32_t slot) {
      const std::uint32_t* v = page->content.triangle[slot].vertex;
      triangles.push_back({number_of(v[0]), number_of(v[1]), number_of(v[2])});
    });
  }
}

}  // namespace omni::haptics
