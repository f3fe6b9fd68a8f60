#include "service/haptics/scene/check_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_block.h"
#include "service/haptics/vehicle/wall_map.h"

namespace omni::haptics {

using base::Vec3;
namespace {

using base::Error;
using base::Ok;
using base::Status;

constexpr double kMaxCurvature_N_m = 1e6;
constexpr double kMaxPlace_m = 2 * kMaxCoordinate_m;  // of a vertex or box, extrusion and rounding included

template <class T>
bool Fits(std::uint64_t offset, std::uint64_t count, std::uint64_t bytes) {
  return offset % alignof(T) == 0 && offset <= bytes && count <= (bytes - offset) / sizeof(T);
}

template <std::size_t N>
bool EndsInside(const char (&name)[N]) {
  return std::memchr(name, 0, N) != nullptr;
}

Status CheckHeader(const Scene& scene) {
  const std::span<const std::byte> block = scene.block();
  if (block.size() < sizeof(SceneHeader)) return Error{"is shorter than a scene's header"};
  SceneHeader h;
  std::memcpy(&h, block.data(), sizeof h);
  if (h.magic != kSceneMagic || h.version != kSceneVersion) return Error{"holds a scene of another version"};
  if (h.bytes != block.size()) return Error{"has another length than its header says"};
  const bool fits =
      Fits<Material>(h.materials, h.material_count, h.bytes) && Fits<Vertex>(h.vertices, h.vertex_count, h.bytes) &&
      Fits<std::uint32_t>(h.region_of, h.region_of_count, h.bytes) &&
      Fits<Triangle>(h.triangles, h.triangle_count, h.bytes) && Fits<TreeNode>(h.nodes, h.node_count, h.bytes) &&
      Fits<WallNode>(h.wall_nodes, h.wall_node_count, h.bytes) &&
      Fits<WallSegment>(h.wall_segments, h.wall_segment_count, h.bytes) &&
      Fits<Object>(h.objects, h.object_count, h.bytes) && Fits<Region>(h.regions, h.region_count, h.bytes) &&
      Fits<Texture>(h.textures, h.texture_count, h.bytes) && Fits<Relief>(h.reliefs, h.relief_count, h.bytes) &&
      Fits<std::uint8_t>(h.texels, h.texel_count, h.bytes) && Fits<CornerUv>(h.uvs, h.uv_count, h.bytes);
  if (!fits) return Error{"has a part that lies outside the block"};
  if (h.object_count > kMaxObjects || h.region_count > kMaxRegions || h.triangle_count > kMaxTriangles ||
      h.material_count == 0 || h.texture_count > kMaxTextures || h.relief_count > kMaxReliefs ||
      h.texel_count > kMaxTexels) {
    return Error{"has a count over its limit"};
  }
  if (h.has_joystick > 1 || h.has_vehicle > 1 || !EndsInside(h.name)) return Error{"has a damaged header"};
  // A scene with only a joystick has empty bounds; otherwise they are positions.
  if (!(h.tree_extent_m >= 0 && h.tree_extent_m <= kMaxPlace_m && h.detent_curvature_N_m >= 0 &&
        h.detent_curvature_N_m <= kMaxCurvature_N_m)) {
    return Error{"has a damaged header"};
  }
  if (!(h.tip_radius_m >= 0 && h.tip_radius_m <= kMaxTipRadius_m)) return Error{"has a tip radius out of range"};
  if (!(std::abs(h.magnet_range_m) <= kMaxPlace_m && IsWithin(h.lower_base_m, 1e30) && IsWithin(h.upper_base_m, 1e30)))
    return Error{"has bounds that are not finite"};
  if (h.has_joystick == 1 && !CheckJoystick(h.joystick).ok()) return Error{"has a joystick out of range"};
  if (h.has_vehicle == 1 && !CheckVehicle(h.vehicle).ok()) return Error{"has a vehicle out of range"};
  return Ok{};
}

// A bool or an enumeration whose byte is none of its values must not be read as one.
bool SoundBytes(const Material& m) {
  const auto byte_of = [](const auto& field) {
    unsigned char byte = 0;
    static_assert(sizeof field == 1);
    std::memcpy(&byte, &field, 1);
    return byte;
  };
  return byte_of(m.softness.model) <= 2 && byte_of(m.smooth) <= 1 && byte_of(m.extrude.enabled) <= 1 &&
         byte_of(m.sculpt.enabled) <= 1 && byte_of(m.sculpt.falloff) <= 2 && byte_of(m.sculpt.symmetry) <= 3;
}

bool IsSound(const Texture& t, std::uint64_t texels, const Scene& scene) {
  const bool numbers = std::all_of(std::begin(t.to_image), std::end(t.to_image),
                                   [](double x) { return std::abs(x) <= kMaxTextureTransform; });
  return numbers && t.width > 0 && t.height > 0 && t.first_texel <= scene.header().texel_count &&
         texels <= scene.header().texel_count - t.first_texel && t.uv_set < kMaxUvSets && t.wrap_u <= 2 &&
         t.wrap_v <= 2;
}

Status CheckMaterials(const Scene& scene) {
  for (const Material& m : scene.materials()) {
    if (!SoundBytes(m) || !CheckMaterial(m, 0).ok()) return Error{"has a material out of range"};
    for (const std::int32_t texture : {m.stiffness_texture, m.friction_texture, m.vibrotactile_texture}) {
      if (!(texture == -1 || (texture >= 0 && static_cast<std::uint32_t>(texture) < scene.header().texture_count)))
        return Error{"has a material with a missing texture"};
    }
    if (!(m.relief == -1 || (m.relief >= 0 && static_cast<std::uint32_t>(m.relief) < scene.header().relief_count)))
      return Error{"has a material with a missing relief"};
  }
  for (const Texture& t : scene.textures()) {
    if (!IsSound(t, std::uint64_t{t.width} * std::uint64_t{t.height}, scene)) return Error{"has a damaged texture"};
  }
  for (const Relief& r : scene.reliefs()) {
    const bool sides = r.finest.width <= kMaxReliefSide && r.finest.height <= kMaxReliefSide && r.image_width > 0 &&
                       r.image_height > 0 && r.bands <= kMaxReliefBands;
    const bool steps =
        std::all_of(std::begin(r.step), std::end(r.step), [](float step) { return std::abs(step) <= kMaxReliefStep; });
    if (!(sides && steps && IsSound(r.finest, ReliefTexels(r.finest.width, r.finest.height, r.bands), scene)))
      return Error{"has a damaged relief"};
  }
  return Ok{};
}

Status CheckMesh(const Scene& scene) {
  const SceneHeader& h = scene.header();
  for (const Vertex& v : scene.vertices()) {
    if (!base::IsWithin({v.x, v.y, v.z}, kMaxPlace_m)) return Error{"has a vertex that is out of range"};
  }
  if (h.region_of_count != (h.region_count > 0 ? h.vertex_count : 0))
    return Error{"has regions of other vertices than its own"};
  for (const std::uint32_t region : scene.region_of()) {
    if (region != kNoIndex && region >= h.region_count) return Error{"has a vertex with a missing region"};
  }
  for (const Triangle& t : scene.triangles()) {
    if (t.object >= h.object_count || t.material >= h.material_count ||
        t.component >= scene.objects()[t.object].component_count) {
      return Error{"has a triangle with a missing object, material or component"};
    }
    for (const std::uint32_t v : t.vertex) {
      if (v >= h.vertex_count) return Error{"has a triangle with a missing vertex"};
    }
    for (const std::uint32_t n : t.neighbour) {
      if (n != kNoIndex && n >= h.triangle_count) return Error{"has a triangle with a missing neighbour"};
    }
  }
  return Ok{};
}

// Each neighbour has the two corners of the shared edge: walks around a vertex rely on it.
Status CheckNeighbours(const Scene& scene) {
  const auto triangles = scene.triangles();
  const auto has = [](const Triangle& t, std::uint32_t v) {
    return t.vertex[0] == v || t.vertex[1] == v || t.vertex[2] == v;
  };
  for (const Triangle& t : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.neighbour[k] == kNoIndex) continue;
      const Triangle& other = triangles[t.neighbour[k]];
      if (other.object != t.object || !has(other, t.vertex[k]) || !has(other, t.vertex[(k + 1) % 3])) {
        return Error{"has neighbours that do not share an edge"};
      }
    }
  }
  return Ok{};
}

bool IsPlace(float x) { return std::abs(x) <= kMaxPlace_m; }

// Child k of a node: a finite box, or no child and a box that nothing intersects.
bool IsBox(const TreeNode& node, int k) {
  for (int axis = 0; axis < 3; ++axis) {
    const float lower = node.lower[axis][k], upper = node.upper[axis][k];
    if (node.child[k] == kNoChild) {
      if (!(lower > 1e30F && upper < -1e30F)) return false;
    } else if (!(lower <= upper && IsPlace(lower) && IsPlace(upper))) {
      return false;
    }
  }
  return true;
}

// The tree below one object's root: every node once, no deeper than the stacks of the tick, its triangles the object's.
class TreeCheck {
 public:
  explicit TreeCheck(const Scene& scene) : scene_(scene), seen_(scene.nodes().size(), false) {}

  bool Sound(const Object& object) {
    std::vector<std::pair<std::uint32_t, int>> stack{{object.root, 1}};
    while (!stack.empty()) {
      const auto [index, depth] = stack.back();
      stack.pop_back();
      if (index >= seen_.size() || seen_[index] || depth > kMaxTreeDepth) return false;
      seen_[index] = true;
      const TreeNode& node = scene_.nodes()[index];
      for (int k = 0; k < kTreeWidth; ++k) {
        const std::uint32_t child = node.child[k];
        if (!IsBox(node, k)) return false;
        if (child == kNoChild) continue;
        if ((child & kLeafBit) == 0) {
          stack.emplace_back(child, depth + 1);
        } else if (!LeafSound(LeafRange::Of(child), object)) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  static bool LeafSound(const LeafRange& leaf, const Object& object) {
    const std::uint32_t before = leaf.first - object.first_triangle;
    return before < object.triangle_count && leaf.count <= object.triangle_count - before;
  }

  const Scene& scene_;
  std::vector<bool> seen_;
};

// The tree of the car's walls, as that of an object.
Status CheckWalls(const Scene& scene) {
  const auto nodes = scene.wall_nodes();
  const auto segments = scene.wall_segments();
  for (const WallSegment& s : segments) {
    if (!(base::IsWithin({s.ax, s.ay, 0}, kMaxPlace_m) && base::IsWithin({s.bx, s.by, 0}, kMaxPlace_m) &&
          s.material < scene.header().material_count)) {
      return Error{"has a damaged car wall"};
    }
  }
  std::vector<bool> seen(nodes.size(), false);
  std::vector<std::pair<std::uint32_t, int>> stack;
  if (!nodes.empty()) stack.emplace_back(0, 1);
  while (!stack.empty()) {
    const auto [index, depth] = stack.back();
    stack.pop_back();
    if (index >= nodes.size() || seen[index] || depth > kMaxWallDepth) return Error{"has a damaged tree of car walls"};
    seen[index] = true;
    const WallNode& node = nodes[index];
    const bool places =
        IsPlace(node.lower[0]) && IsPlace(node.lower[1]) && IsPlace(node.upper[0]) && IsPlace(node.upper[1]);
    const bool leaf_fits = node.first <= segments.size() && node.count <= segments.size() - node.first;
    if (!places || (node.count > 0 && !leaf_fits) || node.first == kNoIndex)
      return Error{"has a damaged tree of car walls"};
    if (node.count > 0) continue;
    stack.emplace_back(node.first, depth + 1);
    stack.emplace_back(node.first + 1, depth + 1);
  }
  return Ok{};
}

Status CheckObjects(const Scene& scene) {
  const SceneHeader& h = scene.header();
  TreeCheck tree(scene);
  for (const Object& object : scene.objects()) {
    const bool inside = object.first_triangle <= h.triangle_count &&
                        object.triangle_count <= h.triangle_count - object.first_triangle && EndsInside(object.name);
    if (!inside) return Error{"has an object with missing triangles"};
    for (const std::uint32_t uv : object.first_uv) {
      if (uv != kNoIndex && !(uv <= h.uv_count && object.triangle_count <= h.uv_count - uv))
        return Error{"has an object with missing texture coordinates"};
    }
    const bool touched = (object.flags & (kCollidable | kCarWall)) != 0;
    if (touched && !(object.triangle_count > 0 && tree.Sound(object))) return Error{"has a damaged tree"};
  }
  for (const Region& region : scene.regions()) {
    if (!(region.object < h.object_count && region.material < h.material_count && IsWithin(region.normal, 1.001) &&
          IsWithin(region.centroid_base_m, kMaxPlace_m) && region.radius_m >= 0 && region.radius_m <= kMaxPlace_m)) {
      return Error{"has a damaged region"};
    }
  }
  return Ok{};
}

}  // namespace

base::Status CheckScene(const Scene& scene) {
  for (const auto check : {CheckHeader, CheckMaterials, CheckMesh, CheckNeighbours, CheckObjects, CheckWalls}) {
    const Status checked = check(scene);
    if (!checked.ok()) return checked;
  }
  return Ok{};
}

}  // namespace omni::haptics
