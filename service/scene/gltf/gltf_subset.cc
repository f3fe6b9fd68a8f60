#include "service/scene/gltf/gltf_subset.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "service/haptics/scene/scene.h"
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

std::size_t ComponentBytes(std::uint64_t type) {
  return std::find_if(std::begin(kComponents), std::end(kComponents),
                      [type](const ComponentRow& row) { return row.type == type; })
      ->bytes;
}

namespace {

constexpr std::uint64_t kMaxElements = 3ull * haptics::kMaxTriangles;  // of one accessor
constexpr std::size_t kMaxInfluenceSets = 8;                           // JOINTS_0 to JOINTS_7: 32 joints per vertex
constexpr std::uint64_t kMaxZeros = 1'000'000;  // elements of accessors without data, which cost a file nothing

constexpr const char* kDraco = "KHR_draco_mesh_compression";

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
  explicit SubsetBuilder(GltfFile& file) : file_(file), views_(file), draco_required_(Requires(file.root(), kDraco)) {}

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
    CheckDraco(json, primitive.pointer, *position);
    primitive.accessor = *position;
    primitive.mode = mode;
    primitive.positions = AddAccessor(*position, kPosition);
    if (const auto indices = ReadIndex(json, primitive.pointer, "indices", accessors))
      primitive.indices = AddAccessor(*indices, kIndex);
    for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
      if ((uv_sets >> set & 1) == 0) continue;
      const std::string name = "TEXCOORD_" + std::to_string(set);
      const auto uv = ReadIndex(*attributes, JoinPointer(primitive.pointer, "attributes"), name.c_str(), accessors);
      if (!uv) continue;
      CheckCount(*uv, *position, JoinPointer(JoinPointer(primitive.pointer, "attributes"), name));
      primitive.uv[set] = AddAccessor(*uv, kUv);
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
      primitive.influences.emplace_back(AddAccessor(*joints, kJoints), AddAccessor(*weights, kWeights));
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
    if (normals) primitive.normals = AddAccessor(*normals, kNormal);
    if (const auto colours = find("COLOR_0")) {
      const Json& json = ElementOf(file_.root(), "accessors", *colours);
      const bool four = FindString(json, JoinPointer("/accessors", *colours), "type", "") == "VEC4";
      primitive.colours = AddAccessor(*colours, four ? kColour4 : kColour3);
    }
  }

  void CheckCount(std::uint32_t accessor, std::uint32_t as_many_as, const std::string& pointer) {
    const auto count = [&](std::uint32_t index) {
      return ReadInteger(ElementOf(file_.root(), "accessors", index), JoinPointer("/accessors", index), "count",
                         kMaxElements, std::nullopt);
    };
    if (count(accessor) != count(as_many_as)) {
      throw LoadError(pointer, "has " + std::to_string(count(accessor)) + " elements, must have " +
                                   std::to_string(count(as_many_as)));
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

  // Without the extension in extensionsRequired a document carries the plain data as well, and that is read.
  void CheckDraco(const Json& primitive, const std::string& pointer, std::uint32_t position) {
    const Json* extensions = FindObject(primitive, pointer, "extensions");
    if (!extensions || !FindMember(*extensions, kDraco)) return;
    if (draco_required_ || !FindMember(ElementOf(file_.root(), "accessors", position), "bufferView")) {
      throw LoadError(pointer, std::string(kDraco) + " is not supported; export without mesh compression");
    }
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
    const Json* normalized = FindMember(json, "normalized");
    if (normalized && !normalized->is_boolean())
      throw LoadError(JoinPointer(pointer, "normalized"), "must be true or false");
    SubsetAccessor packed;
    packed.component = component.type;
    packed.normalized = normalized && normalized->boolean() && component.type != 5126;
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
};

}  // namespace

Subset BuildSubset(GltfFile& file, const std::vector<MeshRequest>& meshes, const std::vector<std::uint32_t>& instanced,
                   std::vector<SkinRequest> skins) {
  return SubsetBuilder(file).Run(meshes, instanced, std::move(skins));
}

}  // namespace omni::scene
