#include "service/scene/drawn_scene.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <utility>

#include "service/scene/gltf/gltf_decode.h"
#include "service/scene/gltf/gltf_file.h"
#include "service/scene/gltf/instances.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/mesh_requests.h"
#include "service/scene/gltf/node_tree.h"

namespace omni::scene {
namespace {

constexpr double kFarthest_m = 1e6;  // of a vertex: beyond, a picture would show no detail

// glTF is y up, the base z up.
glm::dvec3 Upright(const glm::dvec3& p) { return {p.x, -p.z, p.y}; }
base::Vec3 AsVec(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::dvec3 AsGlm(const base::Vec3& v) { return {v.x, v.y, v.z}; }

struct DrawnPaint {
  glm::dvec3 colour{0.5};  // a mid grey, for files without colours
  double roughness = 0.7;
};

double Share(const Json& parent, const std::string& pointer, const char* key, double fallback) {
  const Json* found = FindMember(parent, key);
  if (!found) return fallback;
  const double share = found->number();
  if (!(share >= 0 && share <= 1))
    throw LoadError(JoinPointer(pointer, key), "is " + ValueText(*found) + ", must be a number from 0 to 1");
  return share;
}

class DrawnReader {
 public:
  DrawnReader(std::string path, bool z_up) : path_(std::move(path)), z_up_(z_up) {}

  DrawnScene Run() {
    file_.Open(path_, {}, report_);
    std::vector<std::string> about_touch;  // tags are not drawn
    Warnings warnings(path_, about_touch);
    const std::vector<NodeVisit> nodes = WalkNodes(file_.root(), {.z_up = z_up_}, warnings);
    std::vector<const NodeVisit*> shown;
    for (const NodeVisit& node : nodes) {
      if (node.mesh && !node.hidden) shown.push_back(&node);
    }
    if (shown.empty())
      throw LoadError(Place(), "has no visible node with a mesh: there is nothing to draw; check the export");
    const std::vector<std::size_t> requests = Read(shown, nodes);
    for (std::size_t i = 0; i < shown.size(); ++i) Draw(*shown[i], parts_[requests[i]]);
    if (scene_.parts.empty()) {
      throw LoadError("", "has no triangles to draw" + (skipped_.empty() ? "" : ": " + skipped_));
    }
    NoteUnshown();
    return std::move(scene_);
  }

 private:
  struct MeshPart {
    SubsetPrimitive from;
    DecodedPrimitive decoded;
  };

  // The scene that is shown; "" without any.
  std::string Place() const {
    const std::uint64_t scenes = CountOf(file_.root(), "scenes");
    if (scenes == 0) return CountOf(file_.root(), "nodes") == 0 ? "/nodes" : "";
    return JoinPointer("/scenes", ReadIndex(file_.root(), "", "scene", scenes).value_or(0));
  }

  void Note(const std::string& pointer, const std::string& what) {
    scene_.notes.push_back(path_ + ": " + pointer + ": " + what);
  }

  // The place in parts_ of each of `shown`.
  std::vector<std::size_t> Read(const std::vector<const NodeVisit*>& shown, const std::vector<NodeVisit>& nodes) {
    CheckTriangleCount(file_.root(), shown);
    MeshRequests requests(file_.root(), nodes);
    std::vector<std::size_t> numbers;
    std::vector<std::uint32_t> instanced;
    for (const NodeVisit* node : shown) {
      numbers.push_back(requests.Add(*node));
      requests.meshes()[numbers.back()].paint = true;
      if (IsInstanced(file_.root(), node->node)) instanced.push_back(node->node);
    }
    parts_.resize(requests.meshes().size());
    Subset subset = BuildSubset(file_, requests.meshes(), instanced, requests.skins());
    DecodedSubset decoded = DecodeSubset(subset);
    std::size_t next = 0;
    for (SubsetPrimitive& primitive : subset.primitives) {
      if (primitive.skipped.empty()) {
        parts_[primitive.request].push_back({primitive, std::move(decoded.primitives[next++])});
      } else {
        Note(primitive.pointer, primitive.skipped);
        if (skipped_.empty()) skipped_ = primitive.pointer + " " + primitive.skipped;
      }
    }
    for (std::size_t i = 0; i < subset.instances.size(); ++i) {
      instances_[subset.instances[i].node] = std::move(decoded.instances[i]);
    }
    return numbers;
  }

  void Draw(const NodeVisit& node, const std::vector<MeshPart>& parts) {
    for (const MeshPart& part : parts) {
      if (part.decoded.triangles.empty()) continue;
      if (node.skin && !part.decoded.placed) Note(part.from.pointer, kHasNoJoints);
      const DrawnPaint paint = PaintOf(part.from);
      for (const glm::dmat4& place : PlacesOf(node, part.decoded, instances_)) Draw(node, place, part.decoded, paint);
    }
  }

  DrawnPaint PaintOf(const SubsetPrimitive& primitive) {
    const Json& mesh = ElementOf(file_.root(), "meshes", primitive.mesh);
    const Json& json = FindMember(mesh, "primitives")->elements()[primitive.primitive];
    const auto index = ReadIndex(json, primitive.pointer, "material", CountOf(file_.root(), "materials"));
    DrawnPaint paint;
    if (FindMember(*FindMember(json, "attributes"), "COLOR_0")) paint.colour = glm::dvec3(1);
    if (!index) return paint;
    const std::string pointer = JoinPointer("/materials", *index);
    const Json& material = ElementOf(file_.root(), "materials", *index);
    const Json* pbr = FindObject(material, pointer, "pbrMetallicRoughness");
    if (!pbr) return paint;
    const std::string place = JoinPointer(pointer, "pbrMetallicRoughness");
    if (const auto factor = ReadNumberArray(*pbr, place, "baseColorFactor", 4); !factor.empty())
      paint.colour = glm::clamp(glm::dvec3(factor[0], factor[1], factor[2]), 0.0, 1.0);
    if (FindMember(*pbr, "baseColorTexture")) textured_.insert(place);
    paint.roughness = Share(*pbr, place, "roughnessFactor", paint.roughness);
    return paint;
  }

  void Draw(const NodeVisit& node, const glm::dmat4& place, const DecodedPrimitive& decoded, const DrawnPaint& paint) {
    DrawnPart part{.name = node.name, .roughness = paint.roughness};
    for (const base::Vec3& p : decoded.positions) {
      const glm::dvec3 placed = Upright(glm::dvec3(place * glm::dvec4(AsGlm(p), 1)));
      if (!(glm::length(placed) <= kFarthest_m))
        throw LoadError(node.pointer, "places a vertex beyond 1e6 m; check its transform");
      part.positions_base_m.push_back(AsVec(placed));
    }
    for (std::size_t i = 0; i < decoded.positions.size(); ++i) {
      const glm::dvec3 vertex = decoded.colours.empty() ? glm::dvec3(1) : AsGlm(decoded.colours[i]);
      // Written so that NaN becomes black.
      const auto within = [](double c) { return c > 0 ? std::min(c, 1.0) : 0.0; };
      part.colours.push_back(AsVec(paint.colour * glm::dvec3(within(vertex.x), within(vertex.y), within(vertex.z))));
    }
    part.triangles = decoded.triangles;
    const bool mirrored = (glm::determinant(glm::dmat3(place)) < 0) != decoded.mirrored;
    if (mirrored) {
      for (auto& t : part.triangles) std::swap(t[1], t[2]);
    }
    if (!GiveNormals(place, decoded, part)) Facet(part);
    scene_.parts.push_back(std::move(part));
  }

  // False: the file has none, or one that is no direction. Normals go by the inverse transpose.
  static bool GiveNormals(const glm::dmat4& place, const DecodedPrimitive& decoded, DrawnPart& part) {
    const glm::dmat3 turn(place);
    if (decoded.normals.empty() || !(std::abs(glm::determinant(turn)) > 0)) return false;
    const glm::dmat3 of_normals = glm::transpose(glm::inverse(turn));
    for (const base::Vec3& n : decoded.normals) {
      const glm::dvec3 placed = of_normals * AsGlm(n);
      const double length = glm::length(placed);
      if (!(length > 0 && length <= 1e30)) {
        part.normals_base.clear();
        return false;
      }
      part.normals_base.push_back(AsVec(Upright(placed / length)));
    }
    return true;
  }

  // Each triangle its own vertices and normal   [glTF 2.0, 3.7.2.1: without normals, flat ones]
  static void Facet(DrawnPart& part) {
    DrawnPart flat{.name = std::move(part.name), .roughness = part.roughness};
    for (const auto& triangle : part.triangles) {
      const auto first = static_cast<std::uint32_t>(flat.positions_base_m.size());
      glm::dvec3 corner[3];
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = AsGlm(part.positions_base_m[triangle[k]]);
        flat.positions_base_m.push_back(part.positions_base_m[triangle[k]]);
        flat.colours.push_back(part.colours[triangle[k]]);
      }
      const glm::dvec3 area = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
      const double length = glm::length(area);
      const glm::dvec3 normal = length > 0 ? area / length : glm::dvec3(0, 0, 1);  // no area: nothing of it is seen
      flat.normals_base.insert(flat.normals_base.end(), 3, AsVec(normal));
      flat.triangles.push_back({first, first + 1, first + 2});
    }
    part = std::move(flat);
  }

  void NoteUnshown() {
    for (const std::string& place : textured_)
      Note(JoinPointer(place, "baseColorTexture"), "is not drawn: pictures have the material's colour");
    const std::uint64_t scenes = CountOf(file_.root(), "scenes");
    if (scenes > 1) Note("/scenes", "has " + std::to_string(scenes) + "; only " + Place() + " is drawn");
  }

  const std::string path_;
  const bool z_up_;
  LoadReport report_;
  GltfFile file_;
  std::vector<std::vector<MeshPart>> parts_;  // by request
  InstancesByNode instances_;
  std::set<std::string> textured_;  // materials with an image, by pointer
  std::string skipped_;             // the first primitive that is not drawn, and why
  DrawnScene scene_;
};

}  // namespace

base::Result<DrawnScene> LoadDrawnScene(const std::string& path, bool z_up) {
  try {
    return DrawnReader(path, z_up).Run();
  } catch (const std::bad_alloc&) {
    return base::Error{path + ": does not fit into memory; simplify the model"};
  } catch (const std::exception& error) {
    return base::Error{path + ": " + error.what()};
  }
}

}  // namespace omni::scene
