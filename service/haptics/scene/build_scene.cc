// SceneInput -> Scene: check, repair, connect, index, lay out.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string_view>

#include "service/base/free_memory.h"
#include "service/haptics/extrude/extrude.h"
#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/geometry/tree.h"
#include "service/haptics/scene/check_scene.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_block.h"
#include "service/haptics/vehicle/joystick.h"
#include "service/haptics/vehicle/wall_map.h"

namespace omni::haptics {
namespace {

using base::Error;
using base::Status;

template <std::size_t N>
void CopyName(std::string_view from, char (&to)[N]) {
  const std::size_t n = std::min(from.size(), N - 1);
  from.copy(to, n);
  to[n] = '\0';
}

// Adds the time since it was made, or since the last call, to a phase.
class PhaseClock {
 public:
  void AddTo(double& phase_ms) {
    const auto now = std::chrono::steady_clock::now();
    phase_ms += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

void Say(BuildReport& report, const std::string& object, std::uint64_t count, const char* what) {
  if (count > 0) report.lines.push_back(object + ": " + std::to_string(count) + " " + what);
}

bool IsCracked(const TopologyReport& topology) {
  constexpr double kSolid = 0.38;  // over that of bowls
  return !topology.IsClosed() && topology.solidity > kSolid;
}

// What a person will feel.
const char* Feels(const TopologyReport& topology, bool double_sided) {
  if (topology.IsClosed()) return double_sided ? "felt from both sides, as it is tagged" : "felt as a closed solid";
  if (IsCracked(topology)) {
    return "felt as a solid with cracks or openings: the tip steps over those of up to 0.05 mm, and may go into wider "
           "ones";
  }
  return "felt from both sides, as a sheet; the tip steps over cracks of up to 0.05 mm";
}

void Explain(const std::string& name, bool double_sided, const Mesh& mesh, const RepairCounts& repair,
             const TopologyReport& topology, BuildReport& report) {
  report.lines.push_back(
      name + ": " + std::to_string(mesh.triangles.size()) + " triangles, " + std::to_string(topology.components) +
      (topology.components == 1 ? " component, " : " components, ") + (topology.IsClosed() ? "closed" : "not closed"));
  report.welded_vertices += repair.welded_vertices;
  report.dropped_triangles += repair.not_finite + repair.degenerate + repair.duplicate;
  report.flipped_objects += topology.flipped_components + topology.flipped_triangles > 0;
  report.lines.push_back(name + ": " + Feels(topology, double_sided));
  Say(report, name, repair.welded_vertices, "vertices welded");
  char stitched[64];
  std::snprintf(stitched, sizeof stitched, "vertices welded over cracks, within %g um",
                1e6 * topology.stitched_within_m);
  Say(report, name, topology.stitched, stitched);
  Say(report, name, repair.not_finite, "triangles dropped: coordinates not finite");
  Say(report, name, repair.degenerate, "triangles dropped: no area");
  Say(report, name, repair.duplicate, "triangles dropped: duplicates");
  Say(report, name, topology.snapped, "edges split at vertices that lay on them (T-junctions)");
  Say(report, name, topology.unsnapped,
      "border edges were not split at the vertices on them: so many vertices on edges would take too long");
  Say(report, name, topology.closed_holes, "small holes closed");
  Say(report, name, topology.flipped_triangles, "triangles turned to agree with their neighbours");
  Say(report, name, topology.flipped_components, "components were inside-out, turned outwards by winding number");
  Say(report, name, topology.cavities, "cavities kept (closed, facing inwards, inside another component)");
  Say(report, name, topology.by_volume,
      "components were turned by their own volumes: so many parts that may lie in each other take too long to compare");
  Say(report, name, topology.border_edges, "border edges stay: the mesh is open");
  Say(report, name, topology.non_manifold_edges, "edges with three or more triangles stay");
  Say(report, name, topology.cut_edges, "edges cut: no consistent orientation exists");
}

// Everything of one object that later steps add to the scene.
struct BuiltObject {
  Mesh mesh;
  std::vector<Face> faces;
  Object object{};
};

struct PickedFace {
  std::size_t object;
  const Face* face;
};

// The largest faces of the scene become regions.
std::vector<PickedFace> PickRegions(const std::vector<BuiltObject>& built, BuildReport& report) {
  std::vector<PickedFace> picked;
  for (std::size_t i = 0; i < built.size(); ++i) {
    for (const Face& face : built[i].faces) picked.push_back({i, &face});
  }
  std::stable_sort(picked.begin(), picked.end(),
                   [](const PickedFace& a, const PickedFace& b) { return a.face->area_m2 > b.face->area_m2; });
  if (picked.size() > kMaxRegions) {
    report.lines.push_back(std::to_string(picked.size()) + " extrudable faces, the limit is " +
                           std::to_string(kMaxRegions) + ": the smaller ones stay rigid");
    picked.resize(kMaxRegions);
  }
  return picked;
}

class Assembler {
 public:
  Assembler(const SceneInput& input, SceneParts& parts, BuildReport& report, const base::WorkWatch& watch)
      : input_(input), parts_(parts), report_(report), watch_(watch) {
    parts_.materials = input.materials;
  }

  // Precondition: as many calls to AddObject follow as there are objects in `picked`'s scene.
  void AddRegions(const std::vector<PickedFace>& picked, const std::vector<BuiltObject>& built) {
    for (const BuiltObject& object : built) {
      vertex_count_ += object.mesh.vertices.size();
      triangle_count_ += object.mesh.triangles.size();
    }
    parts_.nodes.reserve(triangle_count_ / 18 + built.size());
    vertex_region_.resize(built.size());
    for (const PickedFace& p : picked) {
      const auto region = static_cast<std::uint32_t>(parts_.regions.size());
      parts_.regions.push_back({p.face->normal, p.face->centroid_base_m, p.face->radius_m, p.face->material,
                                static_cast<std::uint32_t>(p.object)});
      const Mesh& mesh = built[p.object].mesh;
      vertex_region_[p.object].resize(mesh.vertices.size(), kNoIndex);
      for (const std::uint32_t t : p.face->triangles) {
        for (const std::uint32_t v : mesh.triangles[t]) {
          if (vertex_region_[p.object][v] == kNoIndex) vertex_region_[p.object][v] = region;
        }
      }
    }
  }

  void AddObject(std::size_t index, BuiltObject& built) {
    const Mesh& mesh = built.mesh;
    built.object.first_triangle = static_cast<std::uint32_t>(parts_.triangles.size());
    built.object.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    std::fill(std::begin(built.object.first_uv), std::end(built.object.first_uv), kNoIndex);
    // An object that lost all its triangles keeps its index but is never touched.
    if (mesh.triangles.empty()) {
      built.object.flags &= ~(std::uint32_t{kCollidable} | kCarWall);
    } else {
      const Order order = AddTree(index, built);
      PhaseClock clock;
      AddVertices(index, mesh, order);
      base::FreeMemory(built.mesh.vertices);
      AddTriangles(index, mesh, order);
      AddUv(mesh, order, built.object);
      clock.AddTo(report_.layout_ms);
    }
    built.mesh = {};
    base::FreeMemory(vertex_region_[index]);
    parts_.objects.push_back(built.object);
  }

 private:
  // Numbers in the scene, in the order in which the tree's leaves use triangles and vertices.
  struct Order {
    std::vector<std::uint32_t> triangles, vertices;           // mesh index at place
    std::vector<std::uint32_t> triangle_place, vertex_place;  // scene index of mesh index
  };

  Order AddTree(std::size_t index, BuiltObject& built) {
    const Mesh& mesh = built.mesh;
    PhaseClock clock;
    std::vector<TreePrimitive> primitives(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      watch_.Did();
      primitives[t] = Reach(index, mesh, t);
    }
    const BuiltTree tree = AppendTree(primitives, built.object.first_triangle, parts_.nodes, watch_);
    built.object.root = tree.root;
    std::copy_n(tree.lower, 3, built.object.lower_base_m);
    std::copy_n(tree.upper, 3, built.object.upper_base_m);
    clock.AddTo(report_.tree_ms);
    Order order;
    order.triangles.reserve(mesh.triangles.size());
    order.vertices.reserve(mesh.vertices.size());
    order.triangle_place.resize(mesh.triangles.size());
    order.vertex_place.assign(mesh.vertices.size(), kNoIndex);
    const auto first_vertex = static_cast<std::uint32_t>(parts_.vertices.size());
    for (const TreePrimitive& p : primitives) {
      watch_.Did();
      order.triangle_place[p.triangle] =
          built.object.first_triangle + static_cast<std::uint32_t>(order.triangles.size());
      order.triangles.push_back(p.triangle);
      for (const std::uint32_t v : mesh.triangles[p.triangle]) {
        if (order.vertex_place[v] != kNoIndex) continue;
        order.vertex_place[v] = first_vertex + static_cast<std::uint32_t>(order.vertices.size());
        order.vertices.push_back(v);
      }
    }
    clock.AddTo(report_.layout_ms);
    return order;
  }

  void AddVertices(std::size_t index, const Mesh& mesh, const Order& order) {
    parts_.vertices.reserve(vertex_count_);
    if (!parts_.regions.empty()) parts_.region_of.reserve(vertex_count_);
    for (const std::uint32_t v : order.vertices) {
      watch_.Did();
      const Vec3& p = mesh.vertices[v];
      parts_.vertices.push_back({p.x, p.y, p.z});
      if (!parts_.regions.empty()) parts_.region_of.push_back(RegionOf(index, v));
    }
  }

  void AddTriangles(std::size_t index, const Mesh& mesh, const Order& order) {
    parts_.triangles.reserve(triangle_count_);
    for (const std::uint32_t t : order.triangles) {
      watch_.Did();
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = order.vertex_place[mesh.triangles[t][k]];
        const std::uint32_t across = mesh.neighbours[t][k];
        triangle.vertex[k] = v;
        triangle.neighbour[k] = across == kNoIndex ? kNoIndex : order.triangle_place[across];
      }
      triangle.object = static_cast<std::uint16_t>(index);
      triangle.material = mesh.material[t];
      triangle.component = mesh.component[t];
      parts_.triangles.push_back(triangle);
    }
  }

  // One per triangle, in the scene's order.
  void AddUv(const Mesh& mesh, const Order& order, Object& object) {
    for (std::size_t set = 0; set < kMaxUvSets; ++set) {
      if (mesh.uv[set].empty()) continue;
      object.first_uv[set] = static_cast<std::uint32_t>(parts_.uvs.size());
      for (const std::uint32_t t : order.triangles) parts_.uvs.push_back(mesh.uv[set][t]);
    }
  }

  std::uint32_t RegionOf(std::size_t index, std::uint32_t vertex) const {
    return vertex_region_[index].empty() ? kNoIndex : vertex_region_[index][vertex];
  }

  // The box of all places a triangle can be moved to.
  TreePrimitive Reach(std::size_t index, const Mesh& mesh, std::uint32_t t) const {
    std::array<Vec3, 9> places;
    std::size_t count = 0;
    for (const std::uint32_t v : mesh.triangles[t]) {
      const Vec3& rest = mesh.vertices[v];
      places[count++] = rest;
      const std::uint32_t r = RegionOf(index, v);
      if (r == kNoIndex) continue;
      const Region& region = parts_.regions[r];
      const Extrude& extrude = input_.materials[region.material].extrude;
      places[count++] = rest + (extrude.steps_out * extrude.step_m) * region.normal;
      places[count++] = rest - (extrude.steps_in * extrude.step_m) * region.normal;
    }
    return MakePrimitive(std::span(places).first(count), t, count > 3);
  }

  const SceneInput& input_;
  SceneParts& parts_;
  BuildReport& report_;
  const base::WorkWatch& watch_;
  std::size_t vertex_count_ = 0, triangle_count_ = 0;      // of the whole scene
  std::vector<std::vector<std::uint32_t>> vertex_region_;  // of an object without regions: empty
};

BuiltObject BuildObject(SceneInput& input, std::size_t index, BuildReport& report, const base::WorkWatch& watch) {
  InputObject& source = input.objects[index];
  BuiltObject built;
  RepairCounts repair;
  PhaseClock clock;
  built.mesh = RepairMesh(source, repair, watch);
  base::FreeMemory(source.vertices_base_m);
  base::FreeMemory(source.triangles);
  base::FreeMemory(source.triangle_material);
  for (std::vector<CornerUv>& uv : source.uv) base::FreeMemory(uv);
  clock.AddTo(report.repair_ms);
  const TopologyReport topology = ConnectAndOrient(built.mesh, watch);
  clock.AddTo(report.topology_ms);
  Explain(Where(source, index), source.double_sided, built.mesh, repair, topology, report);
  built.faces = FindFaces(built.mesh, input.materials, watch);
  CopyName(source.name, built.object.name);
  built.object.component_count = topology.components;
  const bool closed = topology.IsClosed();
  built.object.flags =
      (closed ? std::uint32_t{kClosed} : 0) | (closed && !source.double_sided ? 0 : std::uint32_t{kDoubleSided}) |
      (source.collidable ? std::uint32_t{kCollidable} : 0) | (source.car_wall ? std::uint32_t{kCarWall} : 0) |
      (source.kinematic ? std::uint32_t{kKinematic} : 0) |
      (IsCracked(topology) && !source.double_sided ? std::uint32_t{kCracked} : 0);
  return built;
}

Texture TextureOf(const InputTexture& from, std::uint32_t first_texel, std::uint32_t width, std::uint32_t height) {
  Texture texture{};
  std::copy(from.to_image.begin(), from.to_image.end(), texture.to_image);
  texture.first_texel = first_texel;
  texture.width = width;
  texture.height = height;
  texture.uv_set = from.uv_set;
  texture.wrap_u = static_cast<std::uint32_t>(from.wrap_u);
  texture.wrap_v = static_cast<std::uint32_t>(from.wrap_v);
  return texture;
}

void AddTextures(const SceneInput& input, SceneParts& parts) {
  std::vector<std::uint32_t> first_texel;
  for (const InputImage& image : input.images) {
    first_texel.push_back(static_cast<std::uint32_t>(parts.texels.size()));
    parts.texels.insert(parts.texels.end(), image.texels.begin(), image.texels.end());
  }
  for (const InputTexture& from : input.textures) {
    const InputImage& image = input.images[from.image];
    parts.textures.push_back(TextureOf(from, first_texel[from.image], image.width, image.height));
  }
  for (const InputRelief& from : input.reliefs) {
    Relief relief{};
    relief.finest = TextureOf(from.texture, first_texel[from.texture.image], from.width, from.height);
    relief.image_width = from.image_width;
    relief.image_height = from.image_height;
    relief.bands = static_cast<std::uint32_t>(from.steps.size());
    std::copy(from.steps.begin(), from.steps.end(), relief.step);
    parts.reliefs.push_back(relief);
  }
}

void FillHeader(const SceneInput& input, SceneParts& parts) {
  SceneHeader& header = parts.header;
  CopyName(input.name, header.name);
  header.has_joystick = input.joystick.has_value();
  header.has_vehicle = input.vehicle.has_value();
  if (input.joystick) header.joystick = *input.joystick;
  if (input.joystick) header.detent_curvature_N_m = DetentCurvature_N_m(*input.joystick);
  if (input.vehicle) header.vehicle = *input.vehicle;
  header.lower_base_m = {1e30, 1e30, 1e30};
  header.upper_base_m = {-1e30, -1e30, -1e30};
  header.tip_radius_m = input.tip_radius_m;
  for (const Object& object : parts.objects) {
    if (object.triangle_count == 0) continue;
    const Vec3 lower{object.lower_base_m[0], object.lower_base_m[1], object.lower_base_m[2]};
    const Vec3 upper{object.upper_base_m[0], object.upper_base_m[1], object.upper_base_m[2]};
    for (const float x : object.lower_base_m)
      header.tree_extent_m = std::max(header.tree_extent_m, std::abs(double{x}));
    for (const float x : object.upper_base_m)
      header.tree_extent_m = std::max(header.tree_extent_m, std::abs(double{x}));
    if ((object.flags & kCollidable) == 0) continue;
    header.lower_base_m = Min(header.lower_base_m, lower);
    header.upper_base_m = Max(header.upper_base_m, upper);
  }
  for (const Material& m : parts.materials) {
    if (m.magnet_max_force_N > 0) header.magnet_range_m = std::max(header.magnet_range_m, m.magnet_range_m);
  }
}

base::Result<Scene> Build(SceneInput& input, BuildReport& report, const base::WorkWatch& watch) {
  const auto start = std::chrono::steady_clock::now();
  report = {};
  const Status checked = CheckInput(input);
  if (!checked.ok()) return Error{checked.error()};
  std::vector<BuiltObject> built;
  built.reserve(input.objects.size());
  for (std::size_t i = 0; i < input.objects.size(); ++i) built.push_back(BuildObject(input, i, report, watch));
  SceneParts parts;
  Assembler assembler(input, parts, report, watch);
  assembler.AddRegions(PickRegions(built, report), built);
  for (std::size_t i = 0; i < built.size(); ++i) assembler.AddObject(i, built[i]);
  if (parts.triangles.empty()) {
    return Error{"scene \"" + input.name + "\": none of its triangles is finite and has area; repair the mesh"};
  }
  AddTextures(input, parts);
  FillHeader(input, parts);
  BuildWalls(parts, watch);
  PhaseClock clock;
  Scene scene = MakeScene(std::move(parts), watch);
  clock.AddTo(report.layout_ms);
  for (std::string& line : ExplainWalls(scene)) report.lines.push_back(std::move(line));
  report.build_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return scene;
}

}  // namespace

base::Result<Scene> BuildScene(SceneInput input, BuildReport& report, const base::WorkWatch& watch) {
  try {
    return Build(input, report, watch);
  } catch (const base::Cancelled& cancelled) {
    return Error{cancelled.what()};
  }
}

}  // namespace omni::haptics
