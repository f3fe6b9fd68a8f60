#include "service/scene/gltf/gltf_subset.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <tuple>
#include <utility>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/draco_mesh.h"
#include "service/scene/gltf/instances.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/view_bytes.h"

namespace omni::scene {
namespace {

constexpr unsigned kColour = kColour3 | kColour4;

constexpr UseRow kUses[] = {
    {kIndex, "SCALAR", 1, "5121, 5123 or 5125 for indices"},
    {kPosition, "VEC3", 3, "5126 (or 5120 to 5123, quantised) for positions"},
    {kUv, "VEC2", 2, "5126 (or 5120 to 5123, quantised) for texture coordinates"},
    {kVector, "VEC3", 3, "5126 for translations and scales"},
    {kRotation, "VEC4", 4, "5126, 5120 or 5122 for rotations"},
    {kNormal, "VEC3", 3, "5126 (or 5120 or 5122, quantised) for normals"},
    {kColour3, "VEC3", 3, "5126, 5121 or 5123 for colours"},
    {kColour4, "VEC4", 4, "5126, 5121 or 5123 for colours"},
    {kJoints, "VEC4", 4, "5121 or 5123 for joints"},
    {kWeights, "VEC4", 4, "5126, 5121 or 5123 for weights"},
    {kMatrix, "MAT4", 16, "5126 for matrices"},
};

constexpr ComponentRow kComponents[] = {
    {5120, 1, kPosition | kUv | kRotation | kNormal},
    {5121, 1, kIndex | kPosition | kUv | kColour | kJoints | kWeights},
    {5122, 2, kPosition | kUv | kRotation | kNormal},
    {5123, 2, kIndex | kPosition | kUv | kColour | kJoints | kWeights},
    {5125, 4, kIndex},
    {5126, 4, kPosition | kUv | kVector | kRotation | kNormal | kColour | kWeights | kMatrix}};

}  // namespace

const UseRow& RowOf(Use use) {
  return *std::find_if(std::begin(kUses), std::end(kUses), [use](const UseRow& row) { return row.use == use; });
}

const ComponentRow& ComponentOf(const Json& parent, const std::string& pointer, Use use) {
  const std::uint64_t type = ReadInteger(parent, pointer, "componentType", 1 << 16, std::nullopt);
  for (const ComponentRow& row : kComponents) {
    if (row.type == type && (row.uses & use) != 0) return row;
  }
  throw LoadError(JoinPointer(pointer, "componentType"),
                  "is " + std::to_string(type) + ", must be " + RowOf(use).allowed);
}

static bool IsAllowed(std::uint64_t type, Use use) {
  return std::any_of(std::begin(kComponents), std::end(kComponents),
                     [&](const ComponentRow& row) { return row.type == type && (row.uses & use) != 0; });
}

std::size_t ComponentBytes(std::uint64_t type) {
  return std::find_if(std::begin(kComponents), std::end(kComponents),
                      [type](const ComponentRow& row) { return row.type == type; })
      ->bytes;
}

namespace {

constexpr std::uint64_t kMaxElements = 3ull * haptics::kMaxTriangles;  // of one accessor
constexpr std::size_t kMaxInfluenceSets = 8;                           // JOINTS_0 to JOINTS_7: 32 joints per vertex
constexpr std::uint64_t kMaxZeros = 1'000'000;  // elements of accessors without data, which cost a file nothing

const char* ModeName(std::uint64_t mode) {
  constexpr const char* kNames[] = {"points", "lines", "a line loop", "a line strip"};
  return kNames[mode];
}

bool Requires(const Json& root, std::string_view extension) {
  const Json* required = FindArray(root, "", "extensionsRequired");
  return required && std::any_of(required->elements().begin(), required->elements().end(),
                                 [extension](const Json& name) { return name.text() == extension; });
}

class SubsetBuilder {
 public:
  explicit SubsetBuilder(GltfFile& file)
      : file_(file), views_(file), draco_required_(Requires(file.root(), kDracoExtension)) {}

  Subset Run(const std::vector<MeshRequest>& meshes, const std::vector<std::uint32_t>& instanced,
             std::vector<SkinRequest> skins) {
    for (SkinRequest& skin : skins) AddSkin(std::move(skin));
    for (std::size_t i = 0; i < meshes.size(); ++i) AddMesh(meshes[i], i);
    for (const std::uint32_t node : instanced) AddInstances(node);
    subset_.bytes = views_.TakeBytes();
    return std::move(subset_);
  }

 private:
  void AddMesh(const MeshRequest& request, std::size_t number) {
    const std::uint32_t mesh = request.mesh;
    const std::string pointer = JoinPointer("/meshes", mesh);
    const Json* primitives = FindArray(ElementOf(file_.root(), "meshes", mesh), pointer, "primitives");
    if (!primitives) throw LoadError(JoinPointer(pointer, "primitives"), "is missing");
    for (std::uint32_t i = 0; i < primitives->elements().size(); ++i) {
      const Json& json = primitives->elements()[i];
      SubsetPrimitive primitive;
      primitive.request = number;
      primitive.mesh = mesh;
      primitive.primitive = i;
      primitive.pointer = JoinPointer(JoinPointer(pointer, "primitives"), i);
      if (!json.is_object()) throw LoadError(primitive.pointer, "must be an object");
      AddPrimitive(json, i < request.uv_sets.size() ? request.uv_sets[i] : std::uint8_t{0}, request, primitive);
      subset_.primitives.push_back(std::move(primitive));
    }
  }

  void AddPrimitive(const Json& json, std::uint8_t uv_sets, const MeshRequest& request, SubsetPrimitive& primitive) {
    const std::uint64_t mode = ReadInteger(json, primitive.pointer, "mode", 6, 4);
    if (mode < 4) {
      primitive.skipped = std::string("is drawn as ") + ModeName(mode) + "; only triangles are read";
      return;
    }
    const std::uint64_t accessors = CountOf(file_.root(), "accessors");
    const Json* attributes = FindObject(json, primitive.pointer, "attributes");
    const auto position =
        attributes ? ReadIndex(*attributes, JoinPointer(primitive.pointer, "attributes"), "POSITION", accessors)
                   : std::nullopt;
    if (!position) {
      primitive.skipped = "has no POSITION";
      return;
    }
    primitive.accessor = *position;
    primitive.mode = mode;
    draco_ = {};
    if (const Json* compressed = CompressedOf(json, primitive.pointer, *position))
      BeginDraco(*compressed, json, *position, primitive);
    primitive.positions = AddAttribute("POSITION", *position, kPosition);
    const auto indices = ReadIndex(json, primitive.pointer, "indices", accessors);
    if (indices && !primitive.indices) primitive.indices = AddAccessor(*indices, kIndex);
    for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
      if ((uv_sets >> set & 1) == 0) continue;
      const std::string name = "TEXCOORD_" + std::to_string(set);
      const auto uv = ReadIndex(*attributes, JoinPointer(primitive.pointer, "attributes"), name.c_str(), accessors);
      if (!uv) continue;
      CheckCount(*uv, *position, JoinPointer(JoinPointer(primitive.pointer, "attributes"), name));
      primitive.uv[set] = AddAttribute(name, *uv, kUv);
      primitive.uv_sets = static_cast<std::uint8_t>(primitive.uv_sets | 1U << set);
    }
    AddMorph(json, request.morph, *position, primitive);
    if (request.skin) AddInfluences(*attributes, *position, *request.skin, primitive);
    if (request.paint) AddPaint(*attributes, *position, primitive);
    primitive.bytes = views_.fresh_bytes();
  }

  // A primitive without targets stays as it is.
  void AddMorph(const Json& json, const std::vector<MorphWeight>& morph, std::uint32_t position,
                SubsetPrimitive& primitive) {
    const Json* targets = FindArray(json, primitive.pointer, "targets");
    const std::string pointer = JoinPointer(primitive.pointer, "targets");
    for (const auto& [target, weight] : morph) {
      if (!targets || targets->elements().empty()) return;
      if (target >= targets->elements().size()) {
        throw LoadError(pointer, "has " + std::to_string(targets->elements().size()) + " elements, but target " +
                                     std::to_string(target) + " has a weight; export the file again");
      }
      const std::string place = JoinPointer(pointer, target);
      const auto moved = ReadIndex(targets->elements()[target], place, "POSITION", CountOf(file_.root(), "accessors"));
      if (!moved) continue;
      CheckCount(*moved, position, JoinPointer(place, "POSITION"));
      primitive.morph.emplace_back(AddAccessor(*moved, kPosition), weight);
    }
  }

  void AddInfluences(const Json& attributes, std::uint32_t position, std::size_t skin, SubsetPrimitive& primitive) {
    const std::string pointer = JoinPointer(primitive.pointer, "attributes");
    for (std::size_t set = 0;; ++set) {
      const auto find = [&](const std::string& name) {
        const auto accessor = ReadIndex(attributes, pointer, name.c_str(), CountOf(file_.root(), "accessors"));
        if (accessor && set < kMaxInfluenceSets) CheckCount(*accessor, position, JoinPointer(pointer, name));
        return accessor;
      };
      const std::string joints_name = "JOINTS_" + std::to_string(set), weights_name = "WEIGHTS_" + std::to_string(set);
      const auto joints = find(joints_name), weights = find(weights_name);
      if (!joints && !weights) break;
      if (!joints || !weights) throw LoadError(JoinPointer(pointer, joints ? weights_name : joints_name), "is missing");
      if (set == kMaxInfluenceSets) {
        throw LoadError(JoinPointer(pointer, joints_name), "is beyond the limit of " + std::to_string(set) +
                                                               " sets of joints; export with fewer per vertex");
      }
      primitive.influences.emplace_back(AddAttribute(joints_name, *joints, kJoints),
                                        AddAttribute(weights_name, *weights, kWeights));
    }
    if (!primitive.influences.empty()) primitive.skin = skin;
  }

  void AddSkin(SkinRequest from) {
    const std::string pointer = JoinPointer("/skins", from.skin);
    const auto inverse = ReadIndex(ElementOf(file_.root(), "skins", from.skin), pointer, "inverseBindMatrices",
                                   CountOf(file_.root(), "accessors"));
    SubsetSkin skin{.from = std::move(from), .inverse_bind = {}};
    if (inverse) {
      skin.inverse_bind = AddAccessor(*inverse, kMatrix);
      const std::size_t count = subset_.accessors[*skin.inverse_bind].count;
      if (count < skin.from.joints.size()) {
        throw LoadError(JoinPointer(pointer, "inverseBindMatrices"), "has " + std::to_string(count) + " elements for " +
                                                                         std::to_string(skin.from.joints.size()) +
                                                                         " joints; export the file again");
      }
    }
    views_.fresh_bytes();
    subset_.skins.push_back(std::move(skin));
  }

  // Of a picture: those of NORMAL and COLOR_0 that are there.
  void AddPaint(const Json& attributes, std::uint32_t position, SubsetPrimitive& primitive) {
    const std::string pointer = JoinPointer(primitive.pointer, "attributes");
    const auto find = [&](const char* name) {
      const auto accessor = ReadIndex(attributes, pointer, name, CountOf(file_.root(), "accessors"));
      if (accessor) CheckCount(*accessor, position, JoinPointer(pointer, name));
      return accessor;
    };
    const bool moved = !primitive.morph.empty() || primitive.skin;  // normals are of the shape as stored
    const auto normals = moved ? std::nullopt : find("NORMAL");
    if (normals) primitive.normals = AddAttribute("NORMAL", *normals, kNormal);
    if (const auto colours = find("COLOR_0")) {
      const Json& json = ElementOf(file_.root(), "accessors", *colours);
      const bool four = FindString(json, JoinPointer("/accessors", *colours), "type", "") == "VEC4";
      primitive.colours = AddAttribute("COLOR_0", *colours, four ? kColour4 : kColour3);
    }
  }

  std::uint64_t ElementCount(std::uint32_t accessor) {
    return ReadInteger(ElementOf(file_.root(), "accessors", accessor), JoinPointer("/accessors", accessor), "count",
                       kMaxElements, std::nullopt);
  }

  void CheckCount(std::uint32_t accessor, std::uint32_t as_many_as, const std::string& pointer) {
    const std::uint64_t own = ElementCount(accessor), others = ElementCount(as_many_as);
    if (own != others) {
      throw LoadError(pointer, "has " + std::to_string(own) + " elements, must have " + std::to_string(others));
    }
  }

  void AddInstances(std::uint32_t node) {
    const std::string pointer =
        JoinPointer(JoinPointer(JoinPointer("/nodes", node), "extensions"), kInstancingExtension);
    const Json& json =
        *FindMember(*FindMember(ElementOf(file_.root(), "nodes", node), "extensions"), kInstancingExtension);
    const Json* attributes = FindObject(json, pointer, "attributes");
    if (!attributes) throw LoadError(JoinPointer(pointer, "attributes"), "is missing");
    SubsetInstances instances;
    instances.node = node;
    instances.count = CountInstances(file_.root(), node);
    const auto add = [&](const char* name, Use use) -> std::optional<std::size_t> {
      const auto accessor =
          ReadIndex(*attributes, JoinPointer(pointer, "attributes"), name, CountOf(file_.root(), "accessors"));
      return accessor ? std::optional(AddAccessor(*accessor, use)) : std::nullopt;
    };
    instances.translation = add("TRANSLATION", kVector);
    instances.rotation = add("ROTATION", kRotation);
    instances.scale = add("SCALE", kVector);
    views_.fresh_bytes();
    subset_.instances.push_back(instances);
  }

  // Null: the primitive is not compressed, or the document carries the plain data as well, which it may where it does
  // not require the extension; that is read then.
  const Json* CompressedOf(const Json& primitive, const std::string& pointer, std::uint32_t position) {
    const Json* extensions = FindObject(primitive, pointer, "extensions");
    const Json* compressed =
        extensions ? FindObject(*extensions, JoinPointer(pointer, "extensions"), kDracoExtension) : nullptr;
    if (!compressed) return nullptr;
    const bool plain = FindMember(ElementOf(file_.root(), "accessors", position), "bufferView") != nullptr;
    return draco_required_ || !plain ? compressed : nullptr;
  }

  // Decodes the primitive's stream, once; its attributes come from it until the next primitive.
  void BeginDraco(const Json& compressed, const Json& json, std::uint32_t position, SubsetPrimitive& primitive) {
    draco_.pointer = JoinPointer(JoinPointer(primitive.pointer, "extensions"), kDracoExtension);
    const auto view = ReadIndex(compressed, draco_.pointer, "bufferView", CountOf(file_.root(), "bufferViews"));
    if (!view) throw LoadError(JoinPointer(draco_.pointer, "bufferView"), "is missing");
    draco_.view = *view;
    draco_.attributes = FindObject(compressed, draco_.pointer, "attributes");
    if (!draco_.attributes) throw LoadError(JoinPointer(draco_.pointer, "attributes"), "is missing");
    const auto indices = ReadIndex(json, primitive.pointer, "indices", CountOf(file_.root(), "accessors"));
    if (!indices)
      throw LoadError(JoinPointer(primitive.pointer, "indices"), "is missing, and compressed meshes have it");
    const std::uint64_t corners = ElementCount(*indices), vertices = ElementCount(position);
    if (primitive.mode != 4 || corners % 3 != 0) {
      throw LoadError(primitive.pointer, "has " + std::to_string(corners) + " indices in mode " +
                                             std::to_string(primitive.mode) +
                                             "; compressed meshes are read as triangles (mode 4)");
    }
    const auto [mesh, fresh] = draco_meshes_.try_emplace(draco_.view);
    if (fresh) {
      const std::vector<unsigned char> stored = views_.ReadStored(draco_.view);
      const std::uint64_t room = views_.CheckRoom(draco_.pointer, 4 * corners + 12 * vertices);
      mesh->second.mesh = std::make_unique<DracoMesh>(draco_.pointer, stored, corners / 3, vertices, room);
      SubsetAccessor run{.component = 5125, .count = static_cast<std::size_t>(corners), .zeros = false, .stride = 4};
      run.offset = views_.ReserveRoom(draco_.pointer, 4 * corners);
      mesh->second.mesh->CopyCorners(views_.data(run.offset));
      subset_.accessors.push_back(run);
      mesh->second.corners = subset_.accessors.size() - 1;
    }
    draco_.mesh = mesh->second.mesh.get();
    if (draco_.mesh->triangles() != corners / 3 || draco_.mesh->vertices() != vertices)
      throw LoadError(draco_.pointer, "is used by primitives whose accessors have different counts");
    primitive.indices = mesh->second.corners;
  }

  // An attribute of the present primitive: out of its compressed stream if it has one that has it.
  std::size_t AddAttribute(const std::string& name, std::uint32_t accessor, Use use) {
    const auto number =
        draco_.mesh ? ReadIndex(*draco_.attributes, JoinPointer(draco_.pointer, "attributes"), name.c_str(), 1ull << 32)
                    : std::nullopt;
    if (!number) return AddAccessor(accessor, use);
    const auto [place, fresh] = draco_numbers_.try_emplace({draco_.view, *number, accessor, use});
    if (!fresh) return place->second;
    const std::string pointer = JoinPointer(JoinPointer(draco_.pointer, "attributes"), name);
    const auto found = draco_.mesh->Find(*number);
    if (!found || found->width != RowOf(use).components || !IsAllowed(found->component, use)) {
      throw LoadError(pointer, "is " + std::to_string(*number) +
                                   ", and its data has no such attribute of this type; "
                                   "export the file again");
    }
    const std::size_t element = found->width * ComponentBytes(found->component);
    SubsetAccessor packed{.component = found->component, .width = found->width, .zeros = false, .stride = element};
    packed.normalized = IsNormalized(ElementOf(file_.root(), "accessors", accessor),
                                     JoinPointer("/accessors", accessor), found->component);
    packed.count = static_cast<std::size_t>(draco_.mesh->vertices());
    packed.offset = views_.ReserveRoom(draco_.pointer, element * draco_.mesh->vertices());
    draco_.mesh->CopyAttribute(*number, views_.data(packed.offset));
    subset_.accessors.push_back(packed);
    return place->second = subset_.accessors.size() - 1;
  }

  static bool IsNormalized(const Json& accessor, const std::string& pointer, std::uint64_t component) {
    const Json* normalized = FindMember(accessor, "normalized");
    if (normalized && !normalized->is_boolean())
      throw LoadError(JoinPointer(pointer, "normalized"), "must be true or false");
    return normalized && normalized->boolean() && component != 5126;
  }

  std::size_t AddAccessor(std::uint32_t index, Use use) {
    const auto found = accessor_numbers_.find({index, use});
    if (found != accessor_numbers_.end()) return found->second;
    const std::string pointer = JoinPointer("/accessors", index);
    const Json& json = ElementOf(file_.root(), "accessors", index);
    const ComponentRow& component = ComponentOf(json, pointer, use);
    const char* type = RowOf(use).type;
    if (FindString(json, pointer, "type", "") != type)
      throw LoadError(JoinPointer(pointer, "type"), std::string("must be ") + type);
    const std::uint64_t count = ReadInteger(json, pointer, "count", kMaxElements, std::nullopt);
    SubsetAccessor packed;
    packed.component = component.type;
    packed.normalized = IsNormalized(json, pointer, component.type);
    packed.width = RowOf(use).components;
    packed.count = static_cast<std::size_t>(count);
    AddData(json, pointer, packed);
    AddSparse(json, pointer, packed);
    subset_.accessors.push_back(packed);
    return accessor_numbers_[{index, use}] = subset_.accessors.size() - 1;
  }

  void AddData(const Json& json, const std::string& pointer, SubsetAccessor& packed) {
    const auto view = ReadIndex(json, pointer, "bufferView", CountOf(file_.root(), "bufferViews"));
    if (!view) return AddZeros(pointer, packed);
    const std::uint64_t element = ElementBytes(packed);
    const std::uint64_t offset = ReadInteger(json, pointer, "byteOffset", kMaxViewOffset, 0);
    const Json& view_json = ElementOf(file_.root(), "bufferViews", *view);
    const std::uint64_t stride = ReadInteger(view_json, JoinPointer("/bufferViews", *view), "byteStride", 252, 0);
    if (!(stride == 0 || (stride >= element && stride % 4 == 0))) {
      throw LoadError(JoinPointer(JoinPointer("/bufferViews", *view), "byteStride"),
                      "is " + std::to_string(stride) + ", must be a multiple of 4 and at least the element's " +
                          std::to_string(element) + " bytes");
    }
    packed.zeros = false;
    packed.stride = static_cast<std::size_t>(stride == 0 ? element : stride);
    const std::uint64_t bytes = packed.count == 0 ? 0 : packed.stride * (packed.count - 1) + element;
    packed.offset = views_.Add(*view, pointer, offset, bytes);
  }

  // Without data all elements are zero   [glTF 2.0, 3.6.2.1]
  void AddZeros(const std::string& pointer, const SubsetAccessor& packed) {
    zeros_ += packed.count;
    if (zeros_ > kMaxZeros) {
      throw LoadError(pointer, "with those before, has " + std::to_string(zeros_) +
                                   " elements without a bufferView, the limit is " + std::to_string(kMaxZeros) +
                                   "; give it the bufferView with its data");
    }
  }

  static std::uint64_t ElementBytes(const SubsetAccessor& packed) {
    return ComponentBytes(packed.component) * packed.width;
  }

  void AddSparse(const Json& json, const std::string& pointer, SubsetAccessor& packed) {
    const Json* sparse = FindObject(json, pointer, "sparse");
    if (!sparse) return;
    const std::string place = JoinPointer(pointer, "sparse");
    packed.changed = static_cast<std::size_t>(ReadInteger(*sparse, place, "count", packed.count, std::nullopt));
    const auto add = [&](const char* part, std::uint64_t element) {
      const std::string part_pointer = JoinPointer(place, part);
      const Json& part_json = *FindMember(*sparse, part);
      const auto view = ReadIndex(part_json, part_pointer, "bufferView", CountOf(file_.root(), "bufferViews"));
      if (!view) throw LoadError(JoinPointer(part_pointer, "bufferView"), "is missing");
      const std::uint64_t offset = ReadInteger(part_json, part_pointer, "byteOffset", kMaxViewOffset, 0);
      return views_.Add(*view, part_pointer, offset, element * packed.changed);
    };
    for (const char* part : {"indices", "values"})
      if (!FindObject(*sparse, place, part)) throw LoadError(JoinPointer(place, part), "is missing");
    packed.index_component = ComponentOf(*FindMember(*sparse, "indices"), JoinPointer(place, "indices"), kIndex).type;
    packed.index_offset = add("indices", ComponentBytes(packed.index_component));
    packed.value_offset = add("values", ElementBytes(packed));
  }

  GltfFile& file_;
  ViewBytes views_;
  Subset subset_;
  std::map<std::pair<std::uint32_t, Use>, std::size_t> accessor_numbers_;
  std::uint64_t zeros_ = 0;
  const bool draco_required_;
  struct DracoStream {
    std::unique_ptr<DracoMesh> mesh;
    std::size_t corners = 0;  // accessor of the subset
  };
  std::map<std::uint32_t, DracoStream> draco_meshes_;  // by bufferView
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, Use>, std::size_t> draco_numbers_;
  struct {
    const DracoMesh* mesh = nullptr;  // null: the present primitive is not compressed
    const Json* attributes = nullptr;
    std::string pointer;
    std::uint32_t view = 0;
  } draco_;
};

}  // namespace

Subset BuildSubset(GltfFile& file, const std::vector<MeshRequest>& meshes, const std::vector<std::uint32_t>& instanced,
                   std::vector<SkinRequest> skins) {
  return SubsetBuilder(file).Run(meshes, instanced, std::move(skins));
}

}  // namespace omni::scene
