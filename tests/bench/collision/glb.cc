// A small reader of binary glTF: POSITION in float and indices of every triangle list, nothing else.
#include <algorithm>
#include <cstring>
#include <fstream>

#include <nlohmann/json.hpp>

#include "service/haptics/haptics.h"
#include "tests/bench/collision/body.h"

namespace omni::collision {
namespace {

using nlohmann::json;

struct Glb {
  json document;
  std::string binary;

  // Calls take(element index, bytes) for each element of the accessor.
  template <class Take>
  bool Each(std::size_t accessor_index, std::size_t element_bytes, Take take) const {
    const json& accessor = document.at("accessors").at(accessor_index);
    if (accessor.contains("sparse") || !accessor.contains("bufferView")) return false;
    const json& view = document.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    const std::size_t stride = view.value("byteStride", element_bytes), count = accessor.at("count");
    const std::size_t begin = view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0});
    if (count > 0 && begin + (count - 1) * stride + element_bytes > binary.size()) return false;
    for (std::size_t i = 0; i < count; ++i) take(i, binary.data() + begin + i * stride);
    return true;
  }
};

std::uint32_t Word(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  if (at + 4 <= bytes.size()) std::memcpy(&word, bytes.data() + at, 4);
  return word;
}

bool AddPrimitive(const Glb& glb, const json& primitive, haptics::InputObject& object) {
  constexpr int kFloat = 5126;
  const std::size_t positions = primitive.at("attributes").at("POSITION");
  if (glb.document.at("accessors").at(positions).at("componentType") != kFloat) return false;
  const auto base = static_cast<std::uint32_t>(object.vertices_base_m.size());
  if (!glb.Each(positions, 12, [&](std::size_t, const char* bytes) {
        float x[3];
        std::memcpy(x, bytes, sizeof x);
        object.vertices_base_m.push_back({x[0], x[1], x[2]});
      })) {
    return false;
  }
  std::vector<std::uint32_t> indices;
  if (primitive.contains("indices")) {
    const std::size_t accessor = primitive.at("indices");
    const int type = glb.document.at("accessors").at(accessor).at("componentType");
    const std::size_t bytes = type == 5125 ? 4 : (type == 5123 ? 2 : 1);
    if (!glb.Each(accessor, bytes, [&](std::size_t, const char* from) {
          std::uint32_t index = 0;
          std::memcpy(&index, from, bytes);
          indices.push_back(base + index);
        })) {
      return false;
    }
  } else {
    for (auto i = base; i < object.vertices_base_m.size(); ++i) indices.push_back(i);
  }
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    if (std::max({indices[i], indices[i + 1], indices[i + 2]}) >= object.vertices_base_m.size()) return false;
    object.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  }
  return true;
}

}  // namespace

base::Result<haptics::InputObject> ReadGlbObject(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (bytes.size() < 28 || bytes.compare(0, 4, "glTF") != 0) return base::Error{path + ": no binary glTF (.glb)"};
  const std::size_t json_bytes = Word(bytes, 12);
  Glb glb{json::parse(bytes.substr(20, json_bytes), nullptr, false), {}};
  if (glb.document.is_discarded()) return base::Error{path + ": its JSON chunk cannot be parsed"};
  if (28 + json_bytes <= bytes.size()) glb.binary = bytes.substr(28 + json_bytes);
  haptics::InputObject object;
  try {
    for (const json& mesh : glb.document.at("meshes")) {
      for (const json& primitive : mesh.at("primitives")) {
        if (primitive.value("mode", 4) != 4) continue;
        if (!AddPrimitive(glb, primitive, object)) {
          return base::Error{path + ": a primitive is not of plain float positions and indices within the BIN chunk"};
        }
      }
    }
  } catch (const json::exception& e) {
    return base::Error{path + ": " + e.what()};
  }
  if (object.triangles.empty()) return base::Error{path + ": no triangles"};
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  for (const Vec3& v : object.vertices_base_m) {
    lower = Min(lower, v);
    upper = Max(upper, v);
  }
  const Vec3 d = upper - lower;
  const double scale = 0.08 / std::max({d.x, d.y, d.z, 1e-12});
  for (Vec3& v : object.vertices_base_m) v = scale * (v - 0.5 * (lower + upper));
  return object;
}

}  // namespace omni::collision
