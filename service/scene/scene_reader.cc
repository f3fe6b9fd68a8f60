#include "service/scene/scene_reader.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/matrix.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "service/haptics/scene.h"
#include "service/scene/gltf_decode.h"
#include "service/scene/gltf_file.h"
#include "service/scene/gltf_subset.h"
#include "service/scene/haptic_binding.h"
#include "service/scene/load_error.h"
#include "service/scene/node_tree.h"
#include "service/scene/reach.h"

namespace omni::scene {
namespace {

base::Vec3 ToBase(const glm::dvec4& p) { return {p.x, -p.z, p.y}; }

}  // namespace

// Everything that is read once and used by the steps below.
class SceneReader::Loader {
 public:
  Loader(std::string path, const LoadOptions& options, LoadReport& report)
      : path_(std::move(path)), options_(options), report_(report), warnings_(path_, report.warnings) {}

  bool ReadBytes() {
    file_.Open(path_, options_.max_file_bytes, report_);
    input_.name = std::filesystem::path(path_).stem().string();
    nodes_ = WalkNodes(file_.root(), options_, warnings_);
    binding_.emplace(file_.root(), warnings_);
    touched_ = Choose();
    if (!report_.skipped) ReadMeshes();
    report_.bytes_read = file_.bytes_read();
    return !report_.skipped;
  }

  Digest FinishDigest() { return file_.FinishDigest(); }

  haptics::SceneInput MakeInput() {
    DecodeMeshes();
    for (const NodeVisit* node : touched_) AddObject(*node, *binding_);
    if (input_.objects.empty() && !input_.joystick) {
      throw LoadError(
          "", "has nothing to touch: no node with triangles; check the export, or the roles in its haptic tags");
    }
    MergeBeyondLimit();
    input_.materials = binding_->TakeMaterials();
    if (input_.materials.empty()) input_.materials.emplace_back();
    report_.fit_scale = Place(input_, options_);
    WarnIfOutOfReach(input_, options_, warnings_);
    ExplainUnread();
    return std::move(input_);
  }

 private:
  // Nodes whose triangles are wanted. Joystick and vehicle need no triangles: they are read here.
  std::vector<const NodeVisit*> Choose() {
    std::vector<bool> tagged;
    tagged.reserve(nodes_.size());
    for (const NodeVisit& node : nodes_) tagged.push_back(binding_->Tagged(node));
    any_tag_ = std::find(tagged.begin(), tagged.end(), true) != tagged.end();
    std::vector<const NodeVisit*> touched;
    if (!any_tag_ && !options_.touch_untagged) {
      Skip();
      return touched;
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const NodeVisit& node = nodes_[i];
      if (node.own && node.own->role == Role::kJoystick) AddJoystick(node);
      if (node.own && node.own->role == Role::kVehicle) AddVehicle(node);
      if (!node.mesh) continue;
      const Role role = binding_->TagOf(node, 0).role.value_or(Role::kSolid);
      if (any_tag_ && !tagged[i]) {
        Explain(node, false, "no haptic tag, and the file has tags elsewhere");
      } else if (role != Role::kSolid && role != Role::kWall) {
        Explain(node, false, std::string("role ") + NameOf(role) + ": seen, not touched");
      } else {
        touched.push_back(&node);
      }
    }
    return touched;
  }

  // A file without any tag asked for no touch: nothing of it but the JSON is read (docs/decisions/0011).
  void Skip() {
    report_.skipped = true;
    const std::uint64_t meshes = CountOf(file_.root(), "meshes");
    report_.rows.push_back({"/meshes", "", false,
                            std::to_string(meshes) +
                                " not read: the file has no haptic tag; tag what is to be felt, or "
                                "ask for all of it (touch = \"all\", --touch-all)",
                            0});
    ExplainUnread();
  }

  void AddJoystick(const NodeVisit& node) {
    if (input_.joystick) {
      warnings_.Add(node.pointer, "is a second joystick and is ignored; a scene has one");
      return;
    }
    input_.joystick = JoystickOf(*node.own, node.pointer, warnings_);
    input_.joystick->centre_base_m = ToBase(node.world[3]);
    Explain(node, true, "joystick: the tip is drawn to this node's origin");
  }

  void AddVehicle(const NodeVisit& node) {
    if (input_.vehicle) {
      warnings_.Add(node.pointer, "is a second vehicle and is ignored; a scene has one");
      return;
    }
    input_.vehicle = VehicleOf(*node.own);
    input_.vehicle->start_base_m = ToBase(node.world[3]);
    const base::Vec3 ahead = ToBase(node.world[0]);
    input_.vehicle->start_heading_rad = std::atan2(ahead.y, ahead.x);
    Explain(node, true, "vehicle: starts at this node's origin, heading along its x axis");
  }

  void ReadMeshes() {
    std::vector<std::uint32_t> meshes;
    std::vector<bool> listed(CountOf(file_.root(), "meshes"), false);
    for (const NodeVisit* node : touched_) {
      if (!listed[*node->mesh]) meshes.push_back(*node->mesh);
      listed[*node->mesh] = true;
    }
    subset_ = BuildSubset(file_, meshes);
  }

  void DecodeMeshes() {
    std::vector<DecodedPrimitive> decoded = DecodeSubset(subset_);
    subset_.glb = {};
    std::size_t next = 0;
    for (SubsetPrimitive& primitive : subset_.primitives) {
      if (primitive.skipped.empty()) {
        by_mesh_[primitive.mesh].push_back({&primitive, std::move(decoded[next++])});
      } else {
        report_.rows.push_back({primitive.pointer, "", false, primitive.skipped, 0});
      }
    }
  }

  void AddObject(const NodeVisit& node, Binding& binding) {
    haptics::InputObject object;
    object.name = node.name;
    std::uint64_t bytes = 0;
    for (auto& [primitive, decoded] : by_mesh_[*node.mesh]) {
      const HapticTag tag = binding.TagOf(node, primitive->primitive);
      object.car_wall = object.car_wall || tag.role == Role::kWall;
      object.double_sided = object.double_sided || tag.double_sided.value_or(false);
      Append(node, decoded, binding.MaterialIndex(tag, primitive->pointer), object);
      bytes += std::exchange(primitive->bytes, 0);
    }
    WarnOfWhatIsNotFollowed(node);
    if (object.triangles.empty()) return Explain(node, false, "no triangles");
    const std::string why = any_tag_ ? (object.car_wall ? "role wall: touched, and the vehicle hits it" : "haptic tag")
                                     : "default material: the file has no haptic tag";
    Explain(node, true, why + ", " + std::to_string(object.triangles.size()) + " triangles", bytes);
    input_.objects.push_back(std::move(object));
  }

  void Append(const NodeVisit& node, const DecodedPrimitive& decoded, std::uint16_t material,
              haptics::InputObject& object) {
    triangles_ += decoded.triangles.size();
    if (triangles_ > haptics::kMaxTriangles) {
      throw LoadError(node.pointer, "with those before, has more than " + std::to_string(haptics::kMaxTriangles) +
                                        " triangles; simplify the model or tag only what is touched");
    }
    const bool mirrored = glm::determinant(glm::dmat3(node.world)) < 0;  // turns triangles inside out
    const auto first = static_cast<std::uint32_t>(object.vertices_base_m.size());
    for (const base::Vec3& p : decoded.positions) {
      const base::Vec3 placed = ToBase(node.world * glm::dvec4(p.x, p.y, p.z, 1));
      if (!(std::abs(placed.x) <= 1e12 && std::abs(placed.y) <= 1e12 && std::abs(placed.z) <= 1e12)) {
        throw LoadError(node.pointer, "places a vertex beyond 1e12 m; check its transform");
      }
      object.vertices_base_m.push_back(placed);
    }
    for (const auto& [a, b, c] : decoded.triangles) {
      object.triangles.push_back({first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
      object.triangle_material.push_back(material);
    }
  }

  void WarnOfWhatIsNotFollowed(const NodeVisit& node) {
    const Json& json = ElementOf(file_.root(), "nodes", node.node);
    const Json* extensions = Find(json, "extensions");
    if (Find(json, "skin"))
      warnings_.Add(Join(node.pointer, "skin"), "is not followed: touch knows the bind pose only");
    if (extensions && Find(*extensions, "EXT_mesh_gpu_instancing")) {
      warnings_.Add(node.pointer, "EXT_mesh_gpu_instancing is not followed: one instance is touched");
    }
  }

  // haptics holds kMaxObjects objects: the surplus of a file with more is joined to the last one of its kind.
  void MergeBeyondLimit() {
    std::vector<haptics::InputObject>& objects = input_.objects;
    if (objects.size() <= haptics::kMaxObjects) return;
    report_.rows.push_back({"/nodes", "", true,
                            std::to_string(objects.size()) + " objects, " + std::to_string(haptics::kMaxObjects) +
                                " are kept apart; the others are joined into one of their kind",
                            0});
    constexpr std::size_t kKinds = 4;
    std::vector<haptics::InputObject> kept(std::make_move_iterator(objects.begin()),
                                           std::make_move_iterator(objects.begin() + haptics::kMaxObjects - kKinds));
    std::map<std::pair<bool, bool>, haptics::InputObject> joined;
    for (std::size_t i = kept.size(); i < objects.size(); ++i) {
      haptics::InputObject& to = joined[{objects[i].double_sided, objects[i].car_wall}];
      if (to.name.empty()) to.name = objects[i].name + " and others";
      to.double_sided = objects[i].double_sided;
      to.car_wall = objects[i].car_wall;
      JoinTo(objects[i], to);
    }
    for (auto& [kind, object] : joined) kept.push_back(std::move(object));
    objects = std::move(kept);
  }

  static void JoinTo(const haptics::InputObject& from, haptics::InputObject& to) {
    const auto first = static_cast<std::uint32_t>(to.vertices_base_m.size());
    to.vertices_base_m.insert(to.vertices_base_m.end(), from.vertices_base_m.begin(), from.vertices_base_m.end());
    for (const auto& [a, b, c] : from.triangles) to.triangles.push_back({first + a, first + b, first + c});
    to.triangle_material.insert(to.triangle_material.end(), from.triangle_material.begin(),
                                from.triangle_material.end());
  }

  void Explain(const NodeVisit& node, bool loaded, const std::string& why, std::uint64_t bytes = 0) {
    report_.rows.push_back({node.pointer, node.name, loaded, why, bytes});
  }

  void ExplainUnread() {
    for (const char* key : {"images", "textures", "animations", "skins", "cameras"}) {
      const std::uint64_t count = CountOf(file_.root(), key);
      if (count > 0) {
        report_.rows.push_back(
            {Join("", key), "", false, std::to_string(count) + " not read: touch does not need them", 0});
      }
    }
  }

  struct MeshPart {
    SubsetPrimitive* primitive;  // the first node that uses it takes its bytes
    DecodedPrimitive decoded;
  };

  const std::string path_;
  const LoadOptions options_;
  LoadReport& report_;
  Warnings warnings_;
  GltfFile file_;
  std::vector<NodeVisit> nodes_;
  std::optional<Binding> binding_;
  std::vector<const NodeVisit*> touched_;  // of nodes_
  haptics::SceneInput input_;
  Subset subset_;
  std::map<std::uint32_t, std::vector<MeshPart>> by_mesh_;
  std::uint64_t triangles_ = 0;
  bool any_tag_ = false;
};

SceneReader::SceneReader(std::string path, const LoadOptions& options, LoadReport& report)
    : loader_(std::make_unique<Loader>(std::move(path), options, report)) {}
SceneReader::~SceneReader() = default;
bool SceneReader::ReadBytes() { return loader_->ReadBytes(); }
Digest SceneReader::FinishDigest() { return loader_->FinishDigest(); }
haptics::SceneInput SceneReader::MakeInput() { return loader_->MakeInput(); }

}  // namespace omni::scene
