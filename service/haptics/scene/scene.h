// Scene: immutable, one relocatable block (offsets, no pointers, no vtables), so that a confined process can build it
// later and so that it can be swapped in at a tick and freed elsewhere. All that changes lives in haptics::State.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "service/base/big_block.h"
#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/base/work_watch.h"
#include "service/haptics/geometry/tree.h"
#include "service/haptics/scene/material.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::haptics {

struct Vertex {
  double x, y, z;  // rest position, base frame, m
};

// `vertex` counter-clockwise from outside; neighbour[k] is across the edge vertex[k] -> vertex[(k+1)%3], kNoIndex:
// border.
// Triangles and vertices are numbered in the order of the tree's leaves: what is near in space is near in memory.
struct Triangle {
  std::uint32_t vertex[3];
  std::uint32_t neighbour[3];
  std::uint32_t component;  // connected surface within the object, counted from 0 per object
  std::uint16_t object;
  std::uint16_t material;
};
static_assert(sizeof(Triangle) == 32);  // two per cache line

struct Object {
  std::uint32_t first_triangle, triangle_count;
  std::uint32_t root;   // of its tree, in `nodes`; meaningful if kCollidable or kCarWall
  std::uint32_t flags;  // kDoubleSided ...
  std::uint32_t component_count;
  float lower_base_m[3], upper_base_m[3];  // bounds, extrude range included
  std::uint32_t first_uv[kMaxUvSets];      // into uvs(), one per triangle from first_triangle on; kNoIndex: none
  char name[48];
};
// kKinematic: the application moves it; the scene holds it where it is at first. kCracked: not closed, but by its
// winding number the walls of a solid.
enum ObjectFlag : std::uint32_t {
  kDoubleSided = 1,
  kCollidable = 2,
  kCarWall = 4,
  kClosed = 8,
  kKinematic = 16,
  kCracked = 32
};

struct Texture {
  double to_image[6];  // as InputTexture's
  std::uint32_t first_texel, width, height;
  std::uint32_t uv_set;
  std::uint32_t wrap_u, wrap_v;  // Wrap
};

// As InputRelief: its bands lie one after the other.
struct Relief {
  Texture finest;
  std::uint32_t image_width, image_height, bands;
  float step[kMaxReliefBands];
};

// Triangles of one connected extrudable face; its vertices move along `normal` by the offset kept in State.
struct Region {
  base::Vec3 normal;  // unit, outwards
  base::Vec3 centroid_base_m;
  double radius_m;  // farthest vertex from the axis through the centroid along `normal`
  std::uint32_t material;
  std::uint32_t object;
};

// Where the plane the car drives on cuts a wall; a binary tree of two-dimensional boxes lies over these.
struct WallSegment {
  double ax, ay, bx, by;  // base frame, m; a == b: a point
  std::uint32_t material;
  std::uint32_t reserved;
};
struct WallNode {
  float lower[2];
  float upper[2];
  std::uint32_t first;  // leaf: first segment; inner: left child (right = left + 1)
  std::uint32_t count;  // 0: inner node
};

struct SceneHeader {
  std::uint32_t magic;
  std::uint32_t version;
  std::uint64_t bytes;
  std::uint32_t vertex_count, region_of_count, triangle_count, node_count, object_count, region_count, material_count;
  std::uint32_t wall_node_count, wall_segment_count, texture_count, relief_count, texel_count, uv_count;
  std::uint32_t has_joystick, has_vehicle, reserved;
  std::uint64_t vertices, region_of, triangles, nodes, objects, regions, materials, wall_nodes, wall_segments, textures,
      reliefs, texels, uvs;  // offsets from the block's start
  JoystickInput joystick;
  double detent_curvature_N_m;  // stiffest direction of the joystick's notches, at any place
  VehicleInput vehicle;
  base::Vec3 lower_base_m, upper_base_m;  // bounds of all collidable objects, extrude range included
  double tree_extent_m;                   // largest |coordinate| in any tree
  double tip_radius_m;                    // as SceneInput's
  double magnet_range_m;                  // largest of all materials that have a magnet, 0: none
  char name[64];
};

class LiveParts;  // live/live_parts.h

using SceneBlock = std::vector<std::byte, base::BigBlockAllocator<std::byte>>;

class Scene {
 public:
  Scene() = default;  // empty scene: nothing to touch, zero cost
  // For bytes that BuildScene did not make, call CheckScene (check_scene.h) before anything else.
  explicit Scene(SceneBlock block) : block_(std::move(block)) {}

  bool empty() const noexcept { return block_.empty(); }
  // What changes while the scene is in use; null: nothing does. Set before the scene is handed to the tick.
  void SetLive(std::shared_ptr<LiveParts> live) { live_ = std::move(live); }
  const std::shared_ptr<LiveParts>& live() const noexcept { return live_; }
  // Precondition for all below: !empty().
  const SceneHeader& header() const noexcept { return *reinterpret_cast<const SceneHeader*>(block_.data()); }
  std::span<const Vertex> vertices() const noexcept { return View<Vertex>(header().vertices, header().vertex_count); }
  // The extrude region that each vertex moves with, or kNoIndex; empty if the scene has no regions.
  std::span<const std::uint32_t> region_of() const noexcept {
    return View<std::uint32_t>(header().region_of, header().region_of_count);
  }
  std::span<const Triangle> triangles() const noexcept {
    return View<Triangle>(header().triangles, header().triangle_count);
  }
  std::span<const TreeNode> nodes() const noexcept { return View<TreeNode>(header().nodes, header().node_count); }
  std::span<const Object> objects() const noexcept { return View<Object>(header().objects, header().object_count); }
  std::span<const Region> regions() const noexcept { return View<Region>(header().regions, header().region_count); }
  std::span<const Material> materials() const noexcept {
    return View<Material>(header().materials, header().material_count);
  }
  std::span<const WallNode> wall_nodes() const noexcept {
    return View<WallNode>(header().wall_nodes, header().wall_node_count);
  }
  std::span<const WallSegment> wall_segments() const noexcept {
    return View<WallSegment>(header().wall_segments, header().wall_segment_count);
  }
  std::span<const Texture> textures() const noexcept {
    return View<Texture>(header().textures, header().texture_count);
  }
  std::span<const Relief> reliefs() const noexcept { return View<Relief>(header().reliefs, header().relief_count); }
  std::span<const std::uint8_t> texels() const noexcept {
    return View<std::uint8_t>(header().texels, header().texel_count);
  }
  std::span<const CornerUv> uvs() const noexcept { return View<CornerUv>(header().uvs, header().uv_count); }
  std::size_t bytes() const noexcept { return block_.size(); }
  std::span<const std::byte> block() const noexcept { return block_; }  // also when empty or unchecked

 private:
  template <class T>
  std::span<const T> View(std::uint64_t offset, std::uint32_t count) const noexcept {
    return {reinterpret_cast<const T*>(block_.data() + offset), count};
  }
  SceneBlock block_;
  std::shared_ptr<LiveParts> live_;
};

// What BuildScene did to the input, one line each, for `omni scene explain`.
struct BuildReport {
  std::vector<std::string> lines;
  std::uint32_t welded_vertices = 0, dropped_triangles = 0, flipped_objects = 0;
  double build_ms = 0;
  double repair_ms = 0, topology_ms = 0, tree_ms = 0, layout_ms = 0;  // phases of it, sums over the objects
};

inline constexpr double kMaxCoordinate_m = 10;  // |x| of a vertex; beyond, a wrong unit is assumed

// Welds vertices, drops degenerate and non-finite triangles, orients closed objects outwards, finds neighbours and
// extrude regions, builds the trees. Bounds of nodes include every offset an extrude region can take.
// `input` is freed object by object. Ended by `watch`: the error "cancelled".
base::Result<Scene> BuildScene(SceneInput input, BuildReport& report, const base::WorkWatch& watch = {});

}  // namespace omni::haptics
