#include "service/scene/gltf_decode.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "service/haptics/scene.h"
#include "service/scene/load_error.h"

namespace omni::scene {
namespace {

constexpr std::uint32_t kUnused = 0xFFFFFFFF;
constexpr std::size_t kMaxSteps = 300'000'000;  // bounds the work that a hostile file can ask for: about a second

template <class T>
T Load(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

// Component -> number; normalised integers: max(c / (2^(b-1) - 1), -1) and c / (2^b - 1)   [glTF 2.0, 3.6.2.2]
double Component(const unsigned char* bytes, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return normalized ? std::max(Load<std::int8_t>(bytes) / 127.0, -1.0) : Load<std::int8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return normalized ? *bytes / 255.0 : *bytes;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return normalized ? std::max(Load<std::int16_t>(bytes) / 32767.0, -1.0) : Load<std::int16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return normalized ? Load<std::uint16_t>(bytes) / 65535.0 : Load<std::uint16_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return Load<std::uint32_t>(bytes);
    default:
      return static_cast<double>(Load<float>(bytes));
  }
}

// Elements of an accessor as rows of `width` numbers. Its ranges were checked when the subset was built.
class Elements {
 public:
  Elements(const tinygltf::Model& model, int index, std::size_t width)
      : accessor_(model.accessors.at(static_cast<std::size_t>(index))), width_(width) {
    numbers_.assign(accessor_.count * width_, 0.0);
    if (accessor_.bufferView >= 0) {
      const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor_.bufferView));
      const std::size_t element = ComponentBytes(accessor_.componentType) * width_;
      const std::size_t stride = view.byteStride == 0 ? element : view.byteStride;
      const unsigned char* data = Data(model, accessor_.bufferView);
      for (std::size_t i = 0; i < accessor_.count; ++i) Row(i, data + i * stride);
    }
    if (accessor_.sparse.isSparse) ApplySparse(model);
  }

  std::size_t count() const { return accessor_.count; }
  const double* operator[](std::size_t i) const { return &numbers_[i * width_]; }

 private:
  static std::size_t ComponentBytes(int type) {
    return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
  }

  static const unsigned char* Data(const tinygltf::Model& model, int view) {
    return model.buffers.at(0).data.data() + model.bufferViews.at(static_cast<std::size_t>(view)).byteOffset;
  }

  void Row(std::size_t i, const unsigned char* from) {
    const std::size_t bytes = ComponentBytes(accessor_.componentType);
    for (std::size_t c = 0; c < width_; ++c) {
      numbers_[i * width_ + c] = Component(from + c * bytes, accessor_.componentType, accessor_.normalized);
    }
  }

  void ApplySparse(const tinygltf::Model& model) {
    const auto& sparse = accessor_.sparse;
    if (sparse.count <= 0) return;
    const unsigned char* indices = Data(model, sparse.indices.bufferView);
    const unsigned char* values = Data(model, sparse.values.bufferView);
    const std::size_t index_bytes = ComponentBytes(sparse.indices.componentType);
    const std::size_t element = ComponentBytes(accessor_.componentType) * width_;
    for (std::size_t i = 0; i < static_cast<std::size_t>(sparse.count); ++i) {
      const auto at =
          static_cast<std::size_t>(Component(indices + i * index_bytes, sparse.indices.componentType, false));
      if (at >= accessor_.count) {
        throw LoadError("/accessors", "sparse index " + std::to_string(at) + " is beyond the accessor's " +
                                          std::to_string(accessor_.count) + " elements");
      }
      Row(at, values + i * element);
    }
  }

  const tinygltf::Accessor& accessor_;
  std::size_t width_;
  std::vector<double> numbers_;
};

// Corner numbers of a primitive, three per triangle   [glTF 2.0, 3.7.2.1: strips alternate their winding]
std::vector<std::uint32_t> Corners(const std::vector<std::uint32_t>& run, int mode) {
  std::vector<std::uint32_t> corners;
  const std::size_t n = run.size();
  if (mode == TINYGLTF_MODE_TRIANGLES) return {run.begin(), run.begin() + static_cast<std::ptrdiff_t>(n / 3 * 3)};
  for (std::size_t i = 0; i + 2 < n; ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      corners.insert(corners.end(), {run[i], run[i + 1 + i % 2], run[i + 2 - i % 2]});
    } else {
      corners.insert(corners.end(), {run[i + 1], run[i + 2], run[0]});
    }
  }
  return corners;
}

std::vector<std::uint32_t> VertexRun(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                                     std::size_t vertices, const std::string& pointer) {
  std::vector<std::uint32_t> run;
  if (primitive.indices < 0) {
    for (std::size_t i = 0; i < vertices; ++i) run.push_back(static_cast<std::uint32_t>(i));
    return run;
  }
  const Elements indices(model, primitive.indices, 1);
  for (std::size_t i = 0; i < indices.count(); ++i) {
    const double index = indices[i][0];
    if (!(index < static_cast<double>(vertices))) {
      throw LoadError(pointer + "/indices", "index " + std::to_string(i) + " names vertex " +
                                                std::to_string(static_cast<std::uint64_t>(index)) + " of " +
                                                std::to_string(vertices) + "; export the file again");
    }
    run.push_back(static_cast<std::uint32_t>(index));
  }
  return run;
}

// Three corners of each triangle from a table of the vertices.
std::vector<haptics::CornerUv> CornerUvs(const Elements& uv, const std::vector<std::uint32_t>& corners) {
  std::vector<haptics::CornerUv> triangles(corners.size() / 3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t c = 0; c < 2; ++c) triangles[i / 3][2 * (i % 3) + c] = static_cast<float>(uv[corners[i]][c]);
  }
  return triangles;
}

// An attribute of three components or more at the vertices that are kept. number: of each vertex, or kUnused.
std::vector<base::Vec3> Kept(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const char* name,
                             const std::vector<std::uint32_t>& number, std::size_t kept) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return {};
  const int type = model.accessors.at(static_cast<std::size_t>(found->second)).type;
  const Elements elements(model, found->second, type == TINYGLTF_TYPE_VEC4 ? 4 : 3);
  std::vector<base::Vec3> values(kept);
  for (std::size_t vertex = 0; vertex < number.size(); ++vertex) {
    const double* v = elements[vertex];
    if (number[vertex] != kUnused) values[number[vertex]] = {v[0], v[1], v[2]};
  }
  return values;
}

DecodedPrimitive Decode(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const Elements& positions,
                        const SubsetPrimitive& from) {
  const std::vector<std::uint32_t> corners =
      Corners(VertexRun(model, primitive, positions.count(), from.pointer), primitive.mode);
  DecodedPrimitive decoded;
  std::vector<std::uint32_t> number(positions.count(), kUnused);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t vertex = corners[i];
    if (number[vertex] == kUnused) {
      const double* p = positions[vertex];
      if (!(std::abs(p[0]) <= 1e12 && std::abs(p[1]) <= 1e12 && std::abs(p[2]) <= 1e12)) {
        throw LoadError("/accessors/" + std::to_string(from.accessor),
                        "vertex " + std::to_string(vertex) + " is not finite or beyond 1e12 m; repair the model");
      }
      number[vertex] = static_cast<std::uint32_t>(decoded.positions.size());
      decoded.positions.push_back({p[0], p[1], p[2]});
    }
    if (i % 3 == 0) decoded.triangles.emplace_back();
    decoded.triangles.back()[i % 3] = number[vertex];
  }
  decoded.normals = Kept(model, primitive, "NORMAL", number, decoded.positions.size());
  decoded.colours = Kept(model, primitive, "COLOR_0", number, decoded.positions.size());
  for (std::size_t set = 0; set < haptics::kMaxUvSets; ++set) {
    if ((from.uv_sets >> set & 1) == 0) continue;
    decoded.uv[set] =
        CornerUvs(Elements(model, primitive.attributes.at("TEXCOORD_" + std::to_string(set)), 2), corners);
  }
  return decoded;
}

std::vector<Instance> DecodeInstances(const tinygltf::Model& model, const SubsetInstances& from) {
  std::vector<Instance> instances(static_cast<std::size_t>(from.count));
  const auto fill = [&](const std::optional<std::size_t>& accessor, auto Instance::*field) {
    if (!accessor) return;
    const std::size_t width = (Instance().*field).size();
    const Elements elements(model, static_cast<int>(*accessor), width);
    for (std::size_t i = 0; i < instances.size(); ++i) {
      for (std::size_t c = 0; c < width; ++c) {
        if (!(std::abs(elements[i][c]) <= 1e12)) {
          throw LoadError("/nodes/" + std::to_string(from.node) + "/extensions/EXT_mesh_gpu_instancing",
                          "instance " + std::to_string(i) + " is not finite");
        }
        (instances[i].*field)[c] = elements[i][c];
      }
    }
  };
  fill(from.translation, &Instance::translation);
  fill(from.rotation, &Instance::rotation);
  fill(from.scale, &Instance::scale);
  return instances;
}

}  // namespace

DecodedSubset DecodeSubset(const Subset& subset) {
  tinygltf::TinyGLTF reader;
  tinygltf::Model model;
  std::string error, warning;
  const bool read = reader.LoadBinaryFromMemory(&model, &error, &warning, subset.glb.data(),
                                                static_cast<unsigned int>(subset.glb.size()), "", tinygltf::NO_REQUIRE);
  if (!read) throw LoadError("/meshes", "cannot be read: " + error);
  DecodedSubset all;
  std::vector<DecodedPrimitive>& decoded = all.primitives;
  std::optional<Elements> positions;  // of the last primitive: neighbours often share them
  int accessor = -1;
  std::size_t triangles = 0, steps = 0;
  for (const SubsetPrimitive& from : subset.primitives) {
    if (!from.skipped.empty()) continue;
    const tinygltf::Primitive& primitive = model.meshes.at(decoded.size()).primitives.at(0);
    if (const int wanted = primitive.attributes.at("POSITION"); wanted != accessor) {
      positions.emplace(model, wanted, 3);
      accessor = wanted;
    }
    steps += positions->count();
    if (steps > kMaxSteps) {
      throw LoadError(from.pointer, "with those before, visits more than " + std::to_string(kMaxSteps) +
                                        " vertices; give each primitive its own vertices or join the primitives");
    }
    decoded.push_back(Decode(model, primitive, *positions, from));
    triangles += decoded.back().triangles.size();
    if (triangles > haptics::kMaxTriangles) {
      throw LoadError(from.pointer, "with those before, has more than " + std::to_string(haptics::kMaxTriangles) +
                                        " triangles; simplify the model");
    }
  }
  for (const SubsetInstances& from : subset.instances) all.instances.push_back(DecodeInstances(model, from));
  return all;
}

}  // namespace omni::scene
