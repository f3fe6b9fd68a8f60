#include "service/scene/gltf_subset.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <utility>

#include "service/haptics/scene.h"
#include "service/scene/accessor_use.h"
#include "service/scene/instances.h"
#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

constexpr std::uint64_t kMaxOffset = 1ull << 40;
constexpr std::uint64_t kMaxElements = 3ull * haptics::kMaxTriangles;  // of one accessor
constexpr std::uint64_t kMaxPackedBytes = 1ull << 30;

const char* ModeName(std::uint64_t mode) {
  constexpr const char* kNames[] = {"points", "lines", "a line loop", "a line strip"};
  return kNames[mode];
}

bool Required(const Json& root, const char* extension) {
  const Json* required = FindArray(root, "", "extensionsRequired");
  return required && std::find(required->begin(), required->end(), extension) != required->end();
}

// Byte ranges of the original buffers -> views of one packed buffer. A range asked for twice is read once.
class Packer {
 public:
  explicit Packer(GltfFile& file) : file_(file) {}

  // View of `bytes` bytes at `offset` of bufferView `view`, elements `stride` apart (0: tightly).
  std::size_t AddView(std::uint32_t view, const std::string& pointer, std::uint64_t offset, std::uint64_t bytes,
                      std::uint64_t stride) {
    const Json& json = ElementOf(file_.root(), "bufferViews", view);
    const std::string view_pointer = Join("/bufferViews", view);
    CheckUncompressed(json, view_pointer);
    const auto buffer = Index(json, view_pointer, "buffer", CountOf(file_.root(), "buffers"));
    if (!buffer) throw LoadError(Join(view_pointer, "buffer"), "is missing");
    const std::uint64_t view_offset = Whole(json, view_pointer, "byteOffset", kMaxOffset, 0);
    const std::uint64_t view_length = Whole(json, view_pointer, "byteLength", kMaxOffset, std::nullopt);
    if (!(offset <= view_length && bytes <= view_length - offset)) {
      throw LoadError(pointer, "needs " + std::to_string(bytes) + " bytes at " + std::to_string(offset) + " of " +
                                   view_pointer + ", which has " + std::to_string(view_length) +
                                   "; count, byteOffset or byteStride is wrong");
    }
    const Key key{*buffer, view_offset + offset, bytes, stride};
    if (const auto found = views_.find(key); found != views_.end()) return found->second;
    return views_[key] = Read(key);
  }

  const Json& views() const { return view_json_; }
  const std::vector<unsigned char>& bytes() const { return bytes_; }
  std::uint64_t fresh_bytes() { return std::exchange(fresh_bytes_, 0); }

 private:
  struct Key {
    std::uint32_t buffer;
    std::uint64_t offset, bytes, stride;
    auto operator<=>(const Key&) const = default;  // NOLINT(modernize-use-nullptr): seen in generated code
  };

  static void CheckUncompressed(const Json& view, const std::string& pointer) {
    const Json* extensions = FindObject(view, pointer, "extensions");
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      if (extensions && Find(*extensions, name)) {
        throw LoadError(pointer,
                        std::string(name) + " is not supported; export without mesh compression (gltfpack: no -c)");
      }
    }
  }

  std::size_t Read(const Key& key) {
    const std::size_t at = (bytes_.size() + 3) / 4 * 4;
    if (key.bytes > kMaxPackedBytes - std::min<std::uint64_t>(at, kMaxPackedBytes)) {
      throw LoadError("/bufferViews", "the touched meshes need more than " + std::to_string(kMaxPackedBytes) +
                                          " bytes; simplify the model");
    }
    // Whether the file has these bytes is known before memory is asked for: the read of the last one.
    unsigned char last = 0;
    if (key.bytes > 0) file_.ReadBuffer(key.buffer, key.offset + key.bytes - 1, &last, 1);
    bytes_.resize(at + static_cast<std::size_t>(key.bytes));
    file_.ReadBuffer(key.buffer, key.offset, bytes_.data() + at, static_cast<std::size_t>(key.bytes));
    fresh_bytes_ += key.bytes;
    Json view = {{"buffer", 0}, {"byteOffset", at}, {"byteLength", key.bytes}};
    if (key.stride > 0) view["byteStride"] = key.stride;
    view_json_.push_back(std::move(view));
    return view_json_.size() - 1;
  }

  GltfFile& file_;
  std::map<Key, std::size_t> views_;
  Json view_json_ = Json::array();
  std::vector<unsigned char> bytes_;
  std::uint64_t fresh_bytes_ = 0;
};

class SubsetBuilder {
 public:
  explicit SubsetBuilder(GltfFile& file) : file_(file), packer_(file) {}

  Subset Run(const std::vector<MeshRequest>& meshes, const std::vector<std::uint32_t>& instanced) {
    for (const MeshRequest& mesh : meshes) AddMesh(mesh);
    for (const std::uint32_t node : instanced) AddInstances(node);
    subset_.glb = Glb();
    return std::move(subset_);
  }

 private:
  void AddMesh(const MeshRequest& request) {
    const std::uint32_t mesh = request.mesh;
    const std::string pointer = Join("/meshes", mesh);
    const Json* primitives = FindArray(ElementOf(file_.root(), "meshes", mesh), pointer, "primitives");
    if (!primitives) throw LoadError(Join(pointer, "primitives"), "is missing");
    for (std::uint32_t i = 0; i < primitives->size(); ++i) {
      SubsetPrimitive primitive;
      primitive.mesh = mesh;
      primitive.primitive = i;
      primitive.pointer = Join(Join(pointer, "primitives"), i);
      if (!(*primitives)[i].is_object()) throw LoadError(primitive.pointer, "must be an object");
      AddPrimitive((*primitives)[i], i < request.uv_sets.size() ? request.uv_sets[i] : std::uint8_t{0}, request.paint,
                   primitive);
      subset_.primitives.push_back(std::move(primitive));
    }
  }

  void AddPrimitive(const Json& json, std::uint8_t uv_sets, bool paint, SubsetPrimitive& primitive) {
    const std::uint64_t mode = Whole(json, primitive.pointer, "mode", 6, 4);
    if (mode < 4) {
      primitive.skipped = std::string("is drawn as ") + ModeName(mode) + "; only triangles are read";
      return;
    }
    const std::uint64_t accessors = CountOf(file_.root(), "accessors");
    const Json* attributes = FindObject(json, primitive.pointer, "attributes");
    const auto position =
        attributes ? Index(*attributes, Join(primitive.pointer, "attributes"), "POSITION", accessors) : std::nullopt;
    if (!position) {
      primitive.skipped = "has no POSITION";
      return;
    }
    CheckDraco(json, primitive.pointer, *position);
    primitive.accessor = *position;
    Json mesh = {{"attributes", {{"POSITION", AddAccessor(*position, kPosition)}}}, {"mode", mode}};
    if (const auto indices = Index(json, primitive.pointer, "indices", accessors)) {
      mesh["indices"] = AddAccessor(*indices, kIndex);
    }
    for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
      if ((uv_sets >> set & 1) == 0) continue;
      const std::string name = "TEXCOORD_" + std::to_string(set);
      const auto uv = Index(*attributes, Join(primitive.pointer, "attributes"), name.c_str(), accessors);
      if (!uv) continue;
      CheckCount(*uv, *position, Join(Join(primitive.pointer, "attributes"), name));
      mesh["attributes"][name] = AddAccessor(*uv, kUv);
      primitive.uv_sets = static_cast<std::uint8_t>(primitive.uv_sets | 1U << set);
    }
    if (paint) AddPaint(*attributes, *position, primitive, mesh["attributes"]);
    primitive.bytes = packer_.fresh_bytes();
    meshes_.push_back({{"primitives", Json::array({std::move(mesh)})}});
  }

  // Of a picture: those of NORMAL and COLOR_0 that are there.
  void AddPaint(const Json& attributes, std::uint32_t position, const SubsetPrimitive& primitive, Json& packed) {
    const std::string pointer = Join(primitive.pointer, "attributes");
    for (const char* name : {"NORMAL", "COLOR_0"}) {
      const auto accessor = Index(attributes, pointer, name, CountOf(file_.root(), "accessors"));
      if (!accessor) continue;
      CheckCount(*accessor, position, Join(pointer, name));
      const Json& json = ElementOf(file_.root(), "accessors", *accessor);
      const bool four = FindString(json, Join("/accessors", *accessor), "type", "") == "VEC4";
      packed[name] = AddAccessor(*accessor, name[0] == 'N' ? kNormal : four ? kColour4 : kColour3);
    }
  }

  void CheckCount(std::uint32_t accessor, std::uint32_t as_many_as, const std::string& pointer) {
    const auto count = [&](std::uint32_t index) {
      return Whole(ElementOf(file_.root(), "accessors", index), Join("/accessors", index), "count", kMaxElements,
                   std::nullopt);
    };
    if (count(accessor) != count(as_many_as)) {
      throw LoadError(pointer, "has " + std::to_string(count(accessor)) + " elements, must have " +
                                   std::to_string(count(as_many_as)));
    }
  }

  void AddInstances(std::uint32_t node) {
    const std::string pointer = Join(Join(Join("/nodes", node), "extensions"), kInstancingExtension);
    const Json& json = (*Find(ElementOf(file_.root(), "nodes", node), "extensions"))[kInstancingExtension];
    const Json* attributes = FindObject(json, pointer, "attributes");
    if (!attributes) throw LoadError(Join(pointer, "attributes"), "is missing");
    SubsetInstances instances;
    instances.node = node;
    instances.count = CountInstances(file_.root(), node);
    const auto add = [&](const char* name, Use use) -> std::optional<std::size_t> {
      const auto accessor = Index(*attributes, Join(pointer, "attributes"), name, CountOf(file_.root(), "accessors"));
      return accessor ? std::optional(AddAccessor(*accessor, use)) : std::nullopt;
    };
    instances.translation = add("TRANSLATION", kVector);
    instances.rotation = add("ROTATION", kRotation);
    instances.scale = add("SCALE", kVector);
    packer_.fresh_bytes();
    subset_.instances.push_back(instances);
  }

  // Without the extension in extensionsRequired a document carries the plain data as well, and that is read.
  void CheckDraco(const Json& primitive, const std::string& pointer, std::uint32_t position) {
    constexpr const char* kDraco = "KHR_draco_mesh_compression";
    const Json* extensions = FindObject(primitive, pointer, "extensions");
    if (!extensions || !Find(*extensions, kDraco)) return;
    if (Required(file_.root(), kDraco) || !Find(ElementOf(file_.root(), "accessors", position), "bufferView")) {
      throw LoadError(pointer, std::string(kDraco) + " is not supported; export without mesh compression");
    }
  }

  std::size_t AddAccessor(std::uint32_t index, Use use) {
    const auto found = accessor_numbers_.find({index, use});
    if (found != accessor_numbers_.end()) return found->second;
    const std::string pointer = Join("/accessors", index);
    const Json& json = ElementOf(file_.root(), "accessors", index);
    const ComponentRow& component = ComponentOf(json, pointer, use);
    const char* type = RowOf(use).type;
    if (FindString(json, pointer, "type", "") != type)
      throw LoadError(Join(pointer, "type"), std::string("must be ") + type);
    const std::uint64_t count = Whole(json, pointer, "count", kMaxElements, std::nullopt);
    const Json* normalized = Find(json, "normalized");
    if (normalized && !normalized->is_boolean()) throw LoadError(Join(pointer, "normalized"), "must be true or false");
    Json packed = {{"componentType", component.type}, {"type", type}, {"count", count}};
    if (normalized && component.type != 5126) packed["normalized"] = *normalized;
    const std::uint64_t element = component.bytes * RowOf(use).components;
    AddData(json, pointer, element, count, packed);
    AddSparse(json, pointer, element, count, packed);
    accessors_.push_back(std::move(packed));
    return accessor_numbers_[{index, use}] = accessors_.size() - 1;
  }

  void AddData(const Json& json, const std::string& pointer, std::uint64_t element, std::uint64_t count, Json& packed) {
    const auto view = Index(json, pointer, "bufferView", CountOf(file_.root(), "bufferViews"));
    if (!view) return;  // zeros   [glTF 2.0, 3.6.2.1]
    const std::uint64_t offset = Whole(json, pointer, "byteOffset", kMaxOffset, 0);
    const Json& view_json = ElementOf(file_.root(), "bufferViews", *view);
    const std::uint64_t stride = Whole(view_json, Join("/bufferViews", *view), "byteStride", 252, 0);
    if (!(stride == 0 || (stride >= element && stride % 4 == 0))) {
      throw LoadError(Join(Join("/bufferViews", *view), "byteStride"),
                      "is " + std::to_string(stride) + ", must be a multiple of 4 and at least the element's " +
                          std::to_string(element) + " bytes");
    }
    const std::uint64_t step = stride == 0 ? element : stride;
    const std::uint64_t bytes = count == 0 ? 0 : step * (count - 1) + element;
    packed["bufferView"] = packer_.AddView(*view, pointer, offset, bytes, stride);
  }

  void AddSparse(const Json& json, const std::string& pointer, std::uint64_t element, std::uint64_t count,
                 Json& packed) {
    const Json* sparse = FindObject(json, pointer, "sparse");
    if (!sparse) return;
    const std::string place = Join(pointer, "sparse");
    const std::uint64_t changed = Whole(*sparse, place, "count", count, std::nullopt);
    Json parts = {{"count", changed}};
    for (const char* part : {"indices", "values"}) {
      const std::string part_pointer = Join(place, part);
      const Json* part_json = FindObject(*sparse, place, part);
      if (!part_json) throw LoadError(part_pointer, "is missing");
      const auto view = Index(*part_json, part_pointer, "bufferView", CountOf(file_.root(), "bufferViews"));
      if (!view) throw LoadError(Join(part_pointer, "bufferView"), "is missing");
      const bool is_index = part[0] == 'i';
      const std::uint64_t bytes = is_index ? ComponentOf(*part_json, part_pointer, kIndex).bytes : element;
      const std::uint64_t offset = Whole(*part_json, part_pointer, "byteOffset", kMaxOffset, 0);
      parts[part] = {{"bufferView", packer_.AddView(*view, part_pointer, offset, bytes * changed, 0)},
                     {"byteOffset", 0}};
      if (is_index) parts[part]["componentType"] = (*part_json)["componentType"];
    }
    packed["sparse"] = std::move(parts);
  }

  std::vector<unsigned char> Glb() const {
    Json document = {{"asset", {{"version", "2.0"}}}, {"meshes", meshes_}, {"accessors", accessors_}};
    const std::size_t packed = packer_.bytes().size();
    if (packed > 0) {
      document["buffers"] = Json::array({{{"byteLength", packed}}});
      document["bufferViews"] = packer_.views();
    }
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t bin = (packed + 3) / 4 * 4;
    std::vector<unsigned char> glb(20 + text.size() + (bin > 0 ? 8 + bin : 0), 0);
    const auto put = [&glb](std::size_t at, std::size_t value) {
      for (std::size_t i = 0; i < 4; ++i) glb[at + i] = static_cast<unsigned char>(value >> (8 * i) & 0xFF);
    };
    put(0, 0x46546C67);
    put(4, 2);
    put(8, glb.size());
    put(12, text.size());
    put(16, 0x4E4F534A);
    std::memcpy(&glb[20], text.data(), text.size());
    if (bin > 0) {
      put(20 + text.size(), bin);
      put(24 + text.size(), 0x004E4942);
      std::memcpy(&glb[28 + text.size()], packer_.bytes().data(), packed);
    }
    return glb;
  }

  GltfFile& file_;
  Packer packer_;
  Subset subset_;
  Json accessors_ = Json::array();
  Json meshes_ = Json::array();
  std::map<std::pair<std::uint32_t, Use>, std::size_t> accessor_numbers_;
};

}  // namespace

Subset BuildSubset(GltfFile& file, const std::vector<MeshRequest>& meshes,
                   const std::vector<std::uint32_t>& instanced) {
  return SubsetBuilder(file).Run(meshes, instanced);
}

}  // namespace omni::scene
