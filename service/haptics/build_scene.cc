// SceneInput -> Scene: check, repair, connect, index, lay out.
#include <algorithm>
#include <chrono>
#include <string_view>

#include "service/haptics/check_input.h"
#include "service/haptics/extrude/find_faces.h"
#include "service/haptics/geometry/bvh_build.h"
#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/geometry/mesh_topology.h"
#include "service/haptics/scene_block.h"
#include "service/haptics/vehicle/wall_slice.h"

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

void Say(BuildReport& report, const std::string& object, std::uint64_t count, const char* what) {
  if (count > 0) report.lines.push_back(object + ": " + std::to_string(count) + " " + what);
}

void Explain(const std::string& name, const Mesh& mesh, const RepairCounts& repair, const TopologyReport& topology,
             BuildReport& report) {
  report.lines.push_back(
      name + ": " + std::to_string(mesh.triangles.size()) + " triangles, " + std::to_string(topology.components) +
      (topology.components == 1 ? " component, " : " components, ") + (topology.Closed() ? "closed" : "not closed"));
  report.welded_vertices += repair.welded_vertices;
  report.dropped_triangles += repair.not_finite + repair.degenerate + repair.duplicate;
  report.flipped_objects += topology.flipped_components + topology.flipped_triangles > 0;
  Say(report, name, repair.welded_vertices, "vertices welded");
  Say(report, name, repair.not_finite, "triangles dropped: coordinates not finite");
  Say(report, name, repair.degenerate, "triangles dropped: no area");
  Say(report, name, repair.duplicate, "triangles dropped: duplicates");
  Say(report, name, topology.snapped, "edges split at vertices that lay on them (T-junctions)");
  Say(report, name, topology.closed_holes, "small holes closed");
  Say(report, name, topology.flipped_triangles, "triangles turned to agree with their neighbours");
  Say(report, name, topology.flipped_components, "components were inside-out, turned outwards by winding number");
  Say(report, name, topology.cavities, "cavities kept (closed, facing inwards, inside another component)");
  Say(report, name, topology.border_edges, "border edges: the mesh is open and is touched from both sides");
  Say(report, name, topology.non_manifold_edges, "edges with three or more triangles: touched from both sides");
  Say(report, name, topology.cut_edges, "edges cut: no consistent orientation exists; touched from both sides");
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
  Assembler(const SceneInput& input, SceneParts& parts) : input_(input), parts_(parts) {
    parts_.materials = input.materials;
  }

  // Precondition: as many calls to AddObject follow as there are objects in `picked`'s scene.
  void AddRegions(const std::vector<PickedFace>& picked, const std::vector<BuiltObject>& built) {
    vertex_region_.resize(built.size());
    for (std::size_t i = 0; i < built.size(); ++i) vertex_region_[i].assign(built[i].mesh.vertices.size(), kNoIndex);
    for (const PickedFace& p : picked) {
      const auto region = static_cast<std::uint32_t>(parts_.regions.size());
      parts_.regions.push_back({p.face->normal, p.face->centroid_base_m, p.face->radius_m, p.face->material,
                                static_cast<std::uint32_t>(p.object)});
      for (const std::uint32_t t : p.face->triangles) {
        for (const std::uint32_t v : built[p.object].mesh.triangles[t]) {
          if (vertex_region_[p.object][v] == kNoIndex) vertex_region_[p.object][v] = region;
        }
      }
    }
  }

  void AddObject(std::size_t index, BuiltObject& built) {
    const Mesh& mesh = built.mesh;
    const auto first_vertex = static_cast<std::uint32_t>(parts_.vertices.size());
    const auto first_triangle = static_cast<std::uint32_t>(parts_.triangles.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const Vec3& p = mesh.vertices[v];
      parts_.vertices.push_back({p.x, p.y, p.z, vertex_region_[index][v], kNoIndex});
    }
    std::vector<Box> boxes(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      Triangle triangle{};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = first_vertex + mesh.triangles[t][k];
        const std::uint32_t across = mesh.neighbours[t][k];
        triangle.vertex[k] = v;
        triangle.neighbour[k] = across == kNoIndex ? kNoIndex : first_triangle + across;
        if (parts_.vertices[v].first_triangle == kNoIndex) parts_.vertices[v].first_triangle = first_triangle + t;
        AddReach(parts_.vertices[v], boxes[t]);
      }
      triangle.object = static_cast<std::uint32_t>(index);
      triangle.material = mesh.material[t];
      triangle.component = mesh.component[t];
      parts_.triangles.push_back(triangle);
    }
    AppendUv(mesh, built.object);
    built.object.first_triangle = first_triangle;
    built.object.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    // An object that lost all its triangles keeps its place, never touched.
    if (boxes.empty()) {
      built.object.flags &= ~(std::uint32_t{kCollidable} | kCarWall);
    } else {
      built.object.root = AppendBvh(boxes, first_triangle, parts_.nodes, parts_.leaf_triangles);
    }
    parts_.objects.push_back(built.object);
  }

 private:
  // Precondition: the object's triangles are appended in the order of the mesh.
  void AppendUv(const Mesh& mesh, Object& object) {
    for (std::size_t set = 0; set < kMaxUvSets; ++set) {
      object.first_uv[set] = mesh.uv[set].empty() ? kNoIndex : static_cast<std::uint32_t>(parts_.uvs.size());
      parts_.uvs.insert(parts_.uvs.end(), mesh.uv[set].begin(), mesh.uv[set].end());
    }
  }

  // All places the vertex can be moved to.
  void AddReach(const Vertex& v, Box& box) const {
    const Vec3 rest{v.x, v.y, v.z};
    box.Add(rest);
    if (v.region == kNoIndex) return;
    const Region& region = parts_.regions[v.region];
    const Extrude& extrude = input_.materials[region.material].extrude;
    box.Add(rest + (extrude.steps_out * extrude.step_m) * region.normal);
    box.Add(rest - (extrude.steps_in * extrude.step_m) * region.normal);
  }

  const SceneInput& input_;
  SceneParts& parts_;
  std::vector<std::vector<std::uint32_t>> vertex_region_;
};

BuiltObject BuildObject(const SceneInput& input, std::size_t index, BuildReport& report) {
  const InputObject& source = input.objects[index];
  BuiltObject built;
  RepairCounts repair;
  built.mesh = RepairMesh(source, repair);
  const TopologyReport topology = ConnectAndOrient(built.mesh);
  Explain(Where(source, index), built.mesh, repair, topology, report);
  built.faces = FindFaces(built.mesh, input.materials);
  CopyName(source.name, built.object.name);
  built.object.component_count = topology.components;
  const bool closed = topology.Closed();
  built.object.flags =
      (closed ? std::uint32_t{kClosed} : 0) | (closed && !source.double_sided ? 0 : std::uint32_t{kDoubleSided}) |
      (source.collidable ? std::uint32_t{kCollidable} : 0) | (source.car_wall ? std::uint32_t{kCarWall} : 0) |
      (source.kinematic ? std::uint32_t{kKinematic} : 0);
  return built;
}

void AddTextures(const SceneInput& input, SceneParts& parts) {
  std::vector<std::uint32_t> first_texel;
  for (const InputImage& image : input.images) {
    first_texel.push_back(static_cast<std::uint32_t>(parts.texels.size()));
    parts.texels.insert(parts.texels.end(), image.texels.begin(), image.texels.end());
  }
  for (const InputTexture& from : input.textures) {
    Texture texture{};
    std::copy(from.to_image.begin(), from.to_image.end(), texture.to_image);
    texture.first_texel = first_texel[from.image];
    texture.width = input.images[from.image].width;
    texture.height = input.images[from.image].height;
    texture.uv_set = from.uv_set;
    texture.wrap_u = static_cast<std::uint32_t>(from.wrap_u);
    texture.wrap_v = static_cast<std::uint32_t>(from.wrap_v);
    parts.textures.push_back(texture);
  }
}

void FillHeader(const SceneInput& input, SceneParts& parts) {
  SceneHeader& header = parts.header;
  CopyName(input.name, header.name);
  header.has_joystick = input.joystick.has_value();
  header.has_vehicle = input.vehicle.has_value();
  if (input.joystick) header.joystick = *input.joystick;
  if (input.vehicle) header.vehicle = *input.vehicle;
  header.tip_radius_m = input.tip_radius_m;
  Box bounds;
  for (const Object& object : parts.objects) {
    if ((object.flags & kCollidable) == 0) continue;
    const BvhNode& root = parts.nodes[object.root];
    bounds.Add(Vec3{root.lower[0], root.lower[1], root.lower[2]});
    bounds.Add(Vec3{root.upper[0], root.upper[1], root.upper[2]});
  }
  header.lower_base_m = bounds.lower;
  header.upper_base_m = bounds.upper;
  for (const Material& m : parts.materials) {
    if (m.magnet_max_force_N > 0) header.magnet_range_m = std::max(header.magnet_range_m, m.magnet_range_m);
  }
}

// A car that starts inside a wall could never move, one without walls never hits: say so.
void CheckCarStart(const Scene& scene, BuildReport& report) {
  if (scene.header().has_vehicle == 0) return;
  const VehicleInput& car = scene.header().vehicle;
  const Surface surface(scene, {});
  constexpr double kInSight_m = 1;
  const Wall wall = NearestWall(scene, surface, car.start_base_m, kInSight_m);
  if (!wall.found) report.lines.push_back("vehicle: no car wall at its height; it can drive anywhere");
  if (!wall.found || wall.distance_m >= car.radius_m) return;
  report.lines.push_back("vehicle: starts " + Number(1e3 * wall.distance_m) + " mm from a car wall, its radius is " +
                         Number(1e3 * car.radius_m) + " mm; move the start or the wall");
}

}  // namespace

base::Result<Scene> BuildScene(const SceneInput& input, BuildReport& report) {
  const auto start = std::chrono::steady_clock::now();
  report = {};
  const Status checked = CheckInput(input);
  if (!checked.ok()) return Error{checked.error()};
  std::vector<BuiltObject> built;
  built.reserve(input.objects.size());
  for (std::size_t i = 0; i < input.objects.size(); ++i) built.push_back(BuildObject(input, i, report));
  SceneParts parts;
  Assembler assembler(input, parts);
  assembler.AddRegions(PickRegions(built, report), built);
  for (std::size_t i = 0; i < built.size(); ++i) assembler.AddObject(i, built[i]);
  if (parts.triangles.empty()) {
    return Error{"scene \"" + input.name + "\": none of its triangles is finite and has area; repair the mesh"};
  }
  AddTextures(input, parts);
  FillHeader(input, parts);
  for (std::size_t i = 0; i < input.materials.size(); ++i) {
    if (input.materials[i].softness.model != SoftnessModel::kTet) continue;
    report.lines.push_back("material " + std::to_string(i) + ": softness model tet is rendered as winkler");
  }
  Scene scene = MakeScene(parts);
  CheckCarStart(scene, report);
  report.build_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return scene;
}

}  // namespace omni::haptics
