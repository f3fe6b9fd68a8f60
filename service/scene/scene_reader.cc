#include "service/scene/scene_reader.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "service/base/free_memory.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/draco_mesh.h"
#include "service/scene/gltf/gltf_decode.h"
#include "service/scene/gltf/gltf_file.h"
#include "service/scene/gltf/gltf_subset.h"
#include "service/scene/gltf/instances.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/mesh_requests.h"
#include "service/scene/gltf/meshopt_view.h"
#include "service/scene/gltf/node_tree.h"
#include "service/scene/join_objects.h"
#include "service/scene/reach.h"
#include "service/scene/scene_file.h"
#include "service/scene/tags/haptic_binding.h"
#include "service/scene/tags/haptic_texture.h"

namespace omni::scene {
namespace {

base::Vec3 ToBase(const glm::dvec4& p) { return {p.x, -p.z, p.y}; }

// The node's place and orientation; of one that is mirrored or sheared, a rotation near to its axes.
ObjectSource SourceOf(const NodeVisit& node) {
  ObjectSource source;
  source.node = static_cast<std::int32_t>(node.node);
  for (int k = 0; k < 3; ++k) source.rest_position_m[static_cast<std::size_t>(k)] = node.world[3][k];
  glm::dmat3 axes(node.world);
  if (glm::determinant(axes) < 0) axes = -axes;
  const double x = glm::length(axes[0]);
  const glm::dvec3 u = x > 0 ? axes[0] / x : glm::dvec3(1, 0, 0);
  const glm::dvec3 across = axes[1] - glm::dot(axes[1], u) * u;
  const double y = glm::length(across);
  if (!(x > 0 && y > 1e-9 * x)) return source;
  const glm::dvec3 v = across / y;
  const glm::dquat q = glm::normalize(glm::quat_cast(glm::dmat3(u, v, glm::cross(u, v))));
  source.rest_rotation_wxyz = {q.w, q.x, q.y, q.z};
  return source;
}

}  // namespace

// Everything that is read once and used by the steps below.
class SceneReader::Loader {
 public:
  Loader(std::string path, const LoadOptions& options, LoadReport& report)
      : path_(std::move(path)),
        options_(options),
        report_(report),
        watch_(options.watch ? *options.watch : never_),
        warnings_(path_, report.warnings) {}

  SceneCounts Count() {
    ReadJson();
    SceneCounts counts;
    counts.json_bytes = file_.json_bytes();
    counts.document_bytes = file_.document_bytes();
    counts.nodes = nodes_.size();
    if (report_.skipped) return counts;
    const TextureSizes images = textures_.Measure();
    counts.image_bytes = images.stored_bytes;
    counts.texels = images.texels;
    counts.largest_image_samples = images.largest_samples;
    counts.any_relief = images.any_relief;
    for (const MeshRequest& request : requests_->meshes()) {
      std::size_t i = 0;
      counts.mesh_bytes += requests_->ShapeBytes(request) + DracoBytes(file_.root(), request.mesh);
      for (const PrimitiveSize& size : SizesOf(file_.root(), request.mesh)) {
        counts.mesh_triangles += size.triangles;
        counts.mesh_vertices += size.vertices;
        counts.mesh_bytes += size.bytes;
        if (i < request.uv_sets.size())
          counts.mesh_uv_triangles += size.triangles * static_cast<unsigned>(std::popcount(request.uv_sets[i]));
        ++i;
      }
    }
    if (!touched_.empty()) counts.mesh_bytes += MeshoptBytes(file_.root());
    for (const NodeVisit* node : touched_) counts.objects.push_back(CountObject(*node, counts));
    return counts;
  }

  bool ReadBytes() {
    ReadJson();
    if (!report_.skipped) subset_ = BuildSubset(file_, requests_->meshes(), instanced_, requests_->skins());
    report_.bytes_read = file_.bytes_read();
    return !report_.skipped;
  }

  Digest FinishDigest() { return file_.FinishDigest(); }

  haptics::SceneInput MakeInput() {
    DecodeMeshes();
    for (std::size_t i = 0; i < touched_.size(); ++i) AddObject(*touched_[i], parts_[request_of_[i]]);
    if (input_.objects.empty() && !input_.joystick) {
      const std::string lost(TagsLostBy(file_.root()));
      throw LoadError("",
                      "has nothing to touch: no visible node with triangles; check the export, or the roles in its "
                      "haptic tags" +
                          (lost.empty() ? "" : "; /asset/generator " + lost));
    }
    const std::size_t objects = input_.objects.size();
    if (JoinBeyondLimit(input_.objects)) {
      sources_.resize(kKeptApart);
      report_.rows.push_back({"/nodes", "", true,
                              std::to_string(objects) + " objects, " + std::to_string(haptics::kMaxObjects) +
                                  " are kept apart; the others are joined into one of their kind",
                              0});
    }
    sources_.resize(input_.objects.size());
    report_.objects = std::move(sources_);
    input_.tip_radius_m = TipRadius();
    input_.materials = binding_->TakeMaterials();
    if (input_.materials.empty()) input_.materials.emplace_back();
    const Placing placing = Place(input_, options_);
    report_.fit_scale = placing.fit_scale;
    report_.placed_scale = placing.scale;
    report_.placed_offset_m = placing.offset_m;
    WarnIfOutOfReach(input_, options_, warnings_);
    SuggestUp(input_, options_, placing, warnings_);
    float_steps_.WarnIfFelt(placing.scale, warnings_);
    ExplainUnread();
    return std::move(input_);
  }

 private:
  struct MeshPart {
    SubsetPrimitive* primitive;  // the first node that uses it takes its bytes
    DecodedPrimitive decoded;
  };

  // Nodes whose triangles are wanted. Joystick and vehicle need no triangles: they are read here.
  std::vector<const NodeVisit*> Choose() {
    std::vector<bool> tagged;
    tagged.reserve(nodes_.size());
    for (const NodeVisit& node : nodes_) tagged.push_back(binding_->HasTag(node));
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
      if (node.own && node.own->role == Role::kCheckpoint) AddCheckpoint(node);
      if (!node.mesh) continue;
      const Role role = binding_->TagOf(node, 0).role.value_or(Role::kSolid);
      if (any_tag_ && !tagged[i]) {
        Explain(node, false, "no haptic tag, and the file has tags elsewhere");
      } else if (role != Role::kSolid && role != Role::kWall) {
        Explain(node, false, "role " + std::string(NameOf(role)) + ": seen, not touched");
      } else if (node.hidden && !binding_->HasOwnTag(node)) {
        Explain(node, false,
                "hidden (KHR_node_visibility); give the node a haptic tag of its own to touch it all the same");
      } else {
        touched.push_back(&node);
      }
    }
    GiveCheckpoints();
    return touched;
  }

  // A file without any tag is not touched: nothing of it but the JSON is read (docs/decisions/0011).
  void Skip() {
    report_.skipped = true;
    const std::uint64_t meshes = CountOf(file_.root(), "meshes");
    report_.rows.push_back({"/meshes", "", false,
                            std::to_string(meshes) +
                                " not read: the file has no haptic tag; tag what is to be touched, or "
                                "load all of it (touch = \"all\", --touch-all)",
                            0});
    ExplainUnread();
  }

  void WarnOfLostTags() {
    if (const std::string_view lost = TagsLostBy(file_.root()); !lost.empty())
      warnings_.Add("/asset/generator", std::string(lost));
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
    input_.vehicle->start_heading_rad = HeadingOf(node);
    report_.vehicle = node.name;
    Explain(node, true, "vehicle: starts at this node's origin, heading along its x axis");
  }

  void AddCheckpoint(const NodeVisit& node) {
    if (checkpoints_.size() == haptics::kMaxCheckpoints) {
      warnings_.Add(node.pointer, "is beyond the limit of " + std::to_string(haptics::kMaxCheckpoints) +
                                      " checkpoints and is ignored");
      return;
    }
    haptics::Checkpoint& line = checkpoints_.emplace_back(CheckpointOf(*node.own));
    line.position_base_m = ToBase(node.world[3]);
    line.heading_rad = HeadingOf(node);
    Explain(node, true,
            "checkpoint " + std::to_string(checkpoints_.size()) +
                ": crossed along this node's x axis, in the order of the nodes");
  }

  static double HeadingOf(const NodeVisit& node) {
    const base::Vec3 ahead = ToBase(node.world[0]);
    return std::atan2(ahead.y, ahead.x);
  }

  void GiveCheckpoints() {
    if (!input_.vehicle) return;
    std::copy(checkpoints_.begin(), checkpoints_.end(), input_.vehicle->checkpoints.begin());
    input_.vehicle->checkpoint_count = static_cast<int>(checkpoints_.size());
  }

  double TipRadius() {
    if (CountOf(file_.root(), "scenes") == 0) return options_.tip_radius_m;
    const std::uint32_t scene = ReadIndex(file_.root(), "", "scene", CountOf(file_.root(), "scenes")).value_or(0);
    return ReadTipRadius(ElementOf(file_.root(), "scenes", scene), JoinPointer("/scenes", scene), options_.tip_radius_m,
                         warnings_);
  }

  // Once.
  void ReadJson() {
    if (binding_) return;
    file_.Open(path_, options_, report_);
    input_.name = std::filesystem::path(path_).stem().string();
    named_.emplace(options_.tags_by_name, warnings_);
    const bool unknown_names = named_->WarnOfUnknown(file_.root(), warnings_);
    nodes_ = WalkNodes(file_.root(), options_, warnings_, &*named_);
    binding_.emplace(file_.root(), *named_, warnings_);
    touched_ = Choose();
    if (unknown_names || report_.skipped) WarnOfLostTags();
    if (!report_.skipped) RequestMeshes();
  }

  ObjectCounts CountObject(const NodeVisit& node, SceneCounts& counts) {
    ObjectCounts object;
    const std::uint64_t instances = CountInstances(file_.root(), node.node);
    std::uint32_t i = 0;
    for (const PrimitiveSize& size : SizesOf(file_.root(), *node.mesh)) {
      ++counts.primitives;
      const HapticTag tag = binding_->TagOf(node, i++);
      std::uint64_t sets = 0;
      for (const std::shared_ptr<const TextureUse>& use : tag.textures) sets |= use ? 1U << use->uv_set : 0U;
      object.triangles += instances * size.triangles;
      object.vertices += instances * size.vertices;
      object.uv_triangles += instances * size.triangles * static_cast<unsigned>(std::popcount(sets));
      object.soft = object.soft || tag.softness == haptics::SoftnessModel::kTet;
      object.sculpted = object.sculpted || tag.sculptable.value_or(false);
      object.car_wall = object.car_wall || tag.role == Role::kWall;
    }
    return object;
  }

  void RequestMeshes() {
    CheckTriangleCount(file_.root(), touched_);  // so that a file with too much is refused at once
    requests_.emplace(file_.root(), nodes_);
    for (const NodeVisit* node : touched_) {
      request_of_.push_back(requests_->Add(*node));
      RequestTextures(*node, requests_->meshes()[request_of_.back()]);
      if (IsInstanced(file_.root(), node->node)) instanced_.push_back(node->node);
    }
  }

  void RequestTextures(const NodeVisit& node, MeshRequest& request) {
    const Json* primitives = FindMember(ElementOf(file_.root(), "meshes", *node.mesh), "primitives");
    request.uv_sets.resize(primitives ? primitives->elements().size() : 0, 0);
    for (std::uint32_t i = 0; i < request.uv_sets.size(); ++i) {
      const HapticTag tag = binding_->TagOf(node, i);
      for (const std::shared_ptr<const TextureUse>& use : tag.textures) {
        if (!use) continue;
        textures_.Read(*use);
        request.uv_sets[i] = static_cast<std::uint8_t>(request.uv_sets[i] | 1U << use->uv_set);
      }
    }
  }

  void DecodeMeshes() {
    DecodedSubset decoded = DecodeSubset(subset_, watch_);
    textures_.Decode(watch_);
    report_.images_decoded = textures_.images_decoded();
    base::FreeMemory(subset_.bytes);
    base::FreeMemory(subset_.accessors);
    std::size_t next = 0;
    parts_.resize(requests_->meshes().size());
    std::set<std::string> skipped;  // a mesh in several shapes is said once
    for (SubsetPrimitive& primitive : subset_.primitives) {
      if (primitive.skipped.empty()) {
        parts_[primitive.request].push_back({&primitive, std::move(decoded.primitives[next++])});
      } else if (skipped.insert(primitive.pointer).second) {
        report_.rows.push_back({primitive.pointer, "", false, primitive.skipped, 0});
      }
    }
    for (std::size_t i = 0; i < subset_.instances.size(); ++i) {
      instances_[subset_.instances[i].node] = std::move(decoded.instances[i]);
    }
  }

  void AddObject(const NodeVisit& node, std::vector<MeshPart>& parts) {
    haptics::InputObject object;
    object.name = node.name;
    object.source = node.pointer;
    object.kinematic = options_.all_kinematic;
    std::uint64_t bytes = 0;
    std::size_t copies = 1;
    for (auto& [primitive, decoded] : parts) {
      bytes += std::exchange(primitive->bytes, 0);
      if (decoded.triangles.empty()) continue;
      const HapticTag tag = binding_->TagOf(node, primitive->primitive);
      object.car_wall = object.car_wall || tag.role == Role::kWall;
      object.double_sided = object.double_sided || tag.double_sided.value_or(false);
      object.kinematic = object.kinematic || tag.kinematic.value_or(false);
      const std::uint16_t material = binding_->MaterialIndex(MaterialFor(tag, node, *primitive), primitive->pointer);
      report_.material_uses.push_back({*node.mesh, primitive->primitive, material});
      const std::vector<glm::dmat4> places = PlacesOf(node, decoded, instances_);
      copies = places.size();
      for (const glm::dmat4& place : places) Append(node, place, decoded, material, object);
      if (!places.empty()) float_steps_.Note(node.pointer, places[0], decoded);
      if (node.skin && !decoded.placed) warnings_.Add(primitive->pointer, kHasNoJoints);
    }
    if (object.triangles.empty()) return Explain(node, false, "no triangles");
    std::string why = any_tag_ ? (object.car_wall ? "role wall: touched, and the vehicle hits it" : "haptic tag")
                               : "default material: the file has no haptic tag";
    if (copies > 1) why += ", " + std::to_string(copies) + " instances";
    if (node.skin) why += ", placed by its joints";
    if (node.hidden) why += ", hidden (KHR_node_visibility) but tagged";
    if (object.kinematic) why += ", kinematic";
    Explain(node, true, why + ", " + std::to_string(object.triangles.size()) + " triangles", bytes);
    input_.objects.push_back(std::move(object));
    sources_.push_back(SourceOf(node));
  }

  haptics::Material MaterialFor(const HapticTag& tag, const NodeVisit& node, const SubsetPrimitive& primitive) {
    haptics::Material material = MaterialOf(tag, primitive.pointer, warnings_);
    if (tag.fibre_direction) {
      const auto& [x, y, z] = *tag.fibre_direction;
      const base::Vec3 d = ToBase(node.world * glm::dvec4(x, y, z, 0));
      const double length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
      if (length > 0 && length <= 1e30)
        material.softness.fibre_direction_base = {d.x / length, d.y / length, d.z / length};
    }
    std::int32_t* const fields[] = {&material.stiffness_texture, &material.friction_texture,
                                    &material.vibrotactile_texture, &material.relief};
    for (std::size_t role = 0; role < kTextureRoles; ++role) {
      const std::shared_ptr<const TextureUse>& use = tag.textures[role];
      if (!use) continue;
      if ((primitive.uv_sets >> use->uv_set & 1) != 0) {
        *fields[role] = textures_.IndexOf(*use, input_);
      } else {
        warnings_.Add(primitive.pointer, "has no TEXCOORD_" + std::to_string(use->uv_set) + " for the texture of " +
                                             use->pointer +
                                             (role == kRelief ? ": it is not felt" : ": 1 is used everywhere"));
      }
    }
    return material;
  }

  void Append(const NodeVisit& node, const glm::dmat4& place, const DecodedPrimitive& decoded, std::uint16_t material,
              haptics::InputObject& object) {
    const bool mirrored = (glm::determinant(glm::dmat3(place)) < 0) != decoded.mirrored;  // triangles are inside out
    haptics::InputObject part;
    part.vertices_base_m.reserve(decoded.positions.size());
    for (const base::Vec3& p : decoded.positions) {
      watch_.Did();
      const base::Vec3 placed = ToBase(place * glm::dvec4(p.x, p.y, p.z, 1));
      if (!(std::abs(placed.x) <= 1e12 && std::abs(placed.y) <= 1e12 && std::abs(placed.z) <= 1e12)) {
        throw LoadError(node.pointer, "places a vertex beyond 1e12 m; check its transform");
      }
      part.vertices_base_m.push_back(placed);
    }
    part.triangles = decoded.triangles;
    part.uv = decoded.uv;
    part.triangle_material.assign(part.triangles.size(), material);
    if (mirrored) {
      for (auto& t : part.triangles) std::swap(t[1], t[2]);
      for (auto& set : part.uv) {
        for (haptics::CornerUv& uv : set) uv = {uv[0], uv[1], uv[4], uv[5], uv[2], uv[3]};
      }
    }
    JoinTo(std::move(part), object);
  }

  void Explain(const NodeVisit& node, bool loaded, const std::string& why, std::uint64_t bytes = 0) {
    report_.rows.push_back({node.pointer, node.name, loaded, why, bytes});
  }

  void ExplainUnread() {
    for (const char* key : {"images", "textures", "animations", "skins", "cameras"}) {
      const std::uint64_t count = CountOf(file_.root(), key);
      std::uint64_t used = std::string_view(key) == "images" ? report_.images_decoded : 0;
      if (std::string_view(key) == "skins" && requests_) used = requests_->skins().size();
      if (count > used) {
        report_.rows.push_back(
            {JoinPointer("", key), "", false, std::to_string(count - used) + " not read: not needed for haptics", 0});
      }
      if (used > 0) {
        const bool images = std::string_view(key) == "images";
        report_.rows.push_back({JoinPointer("", key), "", true,
                                std::to_string(used) + (images ? " decoded: a haptic texture needs them"
                                                               : " read: joints place what is touched"),
                                0});
      }
    }
  }

  const std::string path_;
  const LoadOptions options_;
  LoadReport& report_;
  const base::WorkWatch never_;
  const base::WorkWatch& watch_;
  Warnings warnings_;
  GltfFile file_;
  std::vector<NodeVisit> nodes_;
  std::optional<NamedTags> named_;
  std::optional<Binding> binding_;
  std::vector<const NodeVisit*> touched_;  // of nodes_
  haptics::SceneInput input_;
  std::optional<MeshRequests> requests_;
  std::vector<std::size_t> request_of_;   // of requests_, for each of touched_
  std::vector<std::uint32_t> instanced_;  // nodes
  Subset subset_;
  TextureReader textures_{file_, warnings_};
  std::vector<std::vector<MeshPart>> parts_;  // by request
  InstancesByNode instances_;
  std::vector<haptics::Checkpoint> checkpoints_;
  std::vector<ObjectSource> sources_;  // of input_.objects
  FloatSteps float_steps_;
  bool any_tag_ = false;
};

SceneReader::SceneReader(std::string path, const LoadOptions& options, LoadReport& report)
    : loader_(std::make_unique<Loader>(std::move(path), options, report)) {}
SceneReader::~SceneReader() = default;
SceneCounts SceneReader::Count() { return loader_->Count(); }
bool SceneReader::ReadBytes() { return loader_->ReadBytes(); }
Digest SceneReader::FinishDigest() { return loader_->FinishDigest(); }
haptics::SceneInput SceneReader::MakeInput() { return loader_->MakeInput(); }

base::Result<haptics::SceneInput> LoadSceneFile(const std::string& path, const LoadOptions& options,
                                                LoadReport& report) {
  report = {};
  try {
    SceneReader reader(path, options, report);
    if (reader.ReadBytes()) return reader.MakeInput();
    haptics::SceneInput nothing;
    nothing.name = "untagged";
    return nothing;
  } catch (const base::Cancelled& cancelled) {
    return base::Error{cancelled.what()};
  } catch (const std::bad_alloc&) {
    return base::Error{path + ": does not fit into memory; simplify the model"};
  } catch (const std::exception& error) {
    return base::Error{path + ": " + error.what()};
  }
}

}  // namespace omni::scene
