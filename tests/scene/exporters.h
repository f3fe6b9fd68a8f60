// A plain file as exporters write it: welded, sparse, quantised, compressed, joined. Positions, indices, joints and
// weights are written again, instances and inverse bind matrices where a style moves them; other attributes are left
// out.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/scene/compressed.h"

namespace omni::scene::test {

enum class Packing { kNone, kViews, kDraco };

struct Style {
  const char* name;
  bool weld = false, sparse = false;
  bool join = false;        // meshes of all nodes in one, where these nodes have them
  int bits = 0;             // of a position; 0: floats
  bool normalized = false;  // int16, -1 to 1; else uint16 up to 2^bits - 1
  bool exponents = false;   // floats that share an exponent
  Packing packing = Packing::kNone;
  bool fallback = false;  // with the uncompressed bytes in a file beside it
};

// As gltf-transform and gltfpack name them.
inline constexpr Style kStyles[] = {
    {.name = "plain"},
    {.name = "weld", .weld = true},
    {.name = "sparse", .sparse = true},
    {.name = "quantised", .bits = 16, .normalized = true},
    {.name = "draco", .weld = true, .bits = 14, .packing = Packing::kDraco},
    {.name = "meshopt", .weld = true, .bits = 16, .normalized = true, .packing = Packing::kViews},
    {.name = "optimise", .weld = true, .join = true, .bits = 16, .normalized = true, .packing = Packing::kViews},
    {.name = "gltfpack -c", .weld = true, .bits = 14, .packing = Packing::kViews},
    {.name = "gltfpack -cc -vpf", .weld = true, .bits = 20, .exponents = true, .packing = Packing::kViews},
    {.name = "fallback", .weld = true, .bits = 14, .packing = Packing::kViews, .fallback = true},
};

inline constexpr const char* kFallbackFile = "fallback.bin";

class Exporter {
 public:
  // Of `plain`: FLOAT positions, weights and matrices, joints of a byte, indices of two or four; nothing interleaved.
  Exporter(const Model& plain, const Style& style) : plain_(plain), style_(style) {}

  // Once.
  Model Export() {
    out_.json = plain_.json;
    for (const char* key : {"accessors", "bufferViews", "meshes"}) out_.json[key] = Json::array();
    out_.json["buffers"] = Json::array({{{"byteLength", 0}}});
    for (const Json& mesh : plain_.json["meshes"]) {
      std::vector<Part>& parts = meshes_.emplace_back();
      for (const Json& primitive : mesh["primitives"]) parts.push_back(PartOf(primitive));
    }
    if (style_.join) Join();
    for (std::vector<Part>& parts : meshes_) {
      for (Part& part : parts) KeepUsed(part, style_.weld);
      grids_.push_back(GridOf(parts));
      for (const Part& part : parts) index_bytes_ = part.positions.size() > 65'535 ? 4 : index_bytes_;
    }
    KeepOtherData();
    PlaceMeshes();
    for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) WriteMesh(mesh);
    WriteStreams();
    return std::move(out_);
  }

  const std::string& fallback() const { return fallback_; }  // bytes of kFallbackFile

 private:
  using Position = std::array<float, 3>;
  struct Part {  // a primitive
    std::vector<Position> positions;
    std::vector<std::array<std::uint8_t, 4>> joints;  // empty, or of each vertex
    std::vector<std::array<float, 4>> weights;
    std::vector<unsigned> corners;
  };
  struct Grid {  // position = offset + scale * stored
    glm::dvec3 offset{0};
    double scale = 1;
  };
  struct Stream {  // one view of all values of a kind
    const char* mode = "ATTRIBUTES";
    std::size_t stride = 0, view = 0;
    std::string bytes;
  };

  bool Integers() const { return style_.bits > 0 && !style_.exponents && style_.packing != Packing::kDraco; }

  template <class T>
  std::vector<T> Read(std::size_t accessor) const {
    const Json &from = plain_.json["accessors"][accessor],
               &view = plain_.json["bufferViews"][from["bufferView"].get<std::size_t>()];
    std::vector<T> values(from["count"].get<std::size_t>());
    const std::size_t at = view.value("byteOffset", std::size_t{0}) + from.value("byteOffset", std::size_t{0});
    std::memcpy(values.data(), plain_.bin.data() + at, values.size() * sizeof(T));
    return values;
  }

  Part PartOf(const Json& primitive) const {
    const Json& attributes = primitive["attributes"];
    Part part;
    part.positions = Read<Position>(attributes["POSITION"]);
    if (attributes.contains("JOINTS_0")) {
      part.joints = Read<std::array<std::uint8_t, 4>>(attributes["JOINTS_0"]);
      part.weights = Read<std::array<float, 4>>(attributes["WEIGHTS_0"]);
    }
    if (!primitive.contains("indices")) {
      for (unsigned i = 0; i < part.positions.size(); ++i) part.corners.push_back(i);
    } else if (plain_.json["accessors"][primitive["indices"].get<std::size_t>()]["componentType"] == 5123) {
      for (const std::uint16_t vertex : Read<std::uint16_t>(primitive["indices"])) part.corners.push_back(vertex);
    } else {
      part.corners = Read<unsigned>(primitive["indices"]);
    }
    return part;
  }

  // Vertices that are used, in the order of their use; `weld`: equal ones once.
  static void KeepUsed(Part& part, bool weld) {
    using Key = std::tuple<Position, std::array<std::uint8_t, 4>, std::array<float, 4>, unsigned>;
    std::map<Key, unsigned> numbers;
    Part kept;
    for (const unsigned from : part.corners) {
      Key key{part.positions[from], {}, {}, weld ? 0 : from};
      if (!part.joints.empty()) std::get<1>(key) = part.joints[from];
      if (!part.joints.empty()) std::get<2>(key) = part.weights[from];
      const auto [number, fresh] = numbers.try_emplace(key, static_cast<unsigned>(kept.positions.size()));
      kept.corners.push_back(number->second);
      if (!fresh) continue;
      kept.positions.push_back(part.positions[from]);
      if (part.joints.empty()) continue;
      kept.joints.push_back(part.joints[from]);
      kept.weights.push_back(part.weights[from]);
    }
    part = std::move(kept);
  }

  static glm::dmat4 PlaceOf(const Json& node) {
    const auto t = node.value("translation", std::vector<double>{0, 0, 0});
    const auto r = node.value("rotation", std::vector<double>{0, 0, 0, 1});
    const auto s = node.value("scale", std::vector<double>{1, 1, 1});
    glm::dmat4 place = glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2]));
    for (int c = 0; c < 3; ++c) place[c] *= s[static_cast<std::size_t>(c)];
    place[3] = glm::dvec4(t[0], t[1], t[2], 1);
    return place;
  }

  // Meshes of nodes at the root, which nothing else moves.
  void Join() {
    std::vector<Part> joined;
    for (Json& node : out_.json["nodes"]) {
      if (!node.contains("mesh") || node.contains("skin") || node.contains("extensions")) continue;
      for (Part part : meshes_[node["mesh"].get<std::size_t>()]) {
        for (Position& p : part.positions) {
          const glm::dvec4 at = PlaceOf(node) * glm::dvec4(p[0], p[1], p[2], 1);
          for (int c = 0; c < 3; ++c) p[static_cast<std::size_t>(c)] = static_cast<float>(at[c]);
        }
        joined.push_back(std::move(part));
      }
      node.erase("mesh");
    }
    if (joined.empty()) return;
    out_.json["scenes"][0]["nodes"].push_back(out_.json["nodes"].size());
    out_.json["nodes"].push_back({{"mesh", meshes_.size()}});
    meshes_.push_back(std::move(joined));
  }

  Grid GridOf(const std::vector<Part>& parts) const {
    if (!Integers()) return {};
    glm::dvec3 low(1e9), high(-1e9);
    for (const Part& part : parts) {
      for (const Position& p : part.positions) {
        low = glm::min(low, glm::dvec3(p[0], p[1], p[2]));
        high = glm::max(high, glm::dvec3(p[0], p[1], p[2]));
      }
    }
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    if (style_.normalized) return {0.5 * (low + high), extent / 2};
    return {low, extent / ((1 << style_.bits) - 1)};
  }

  // Accessors of instances, and of inverse bind matrices if nothing has to be done with these.
  void KeepOtherData() {
    for (Json& node : out_.json["nodes"]) {
      if (!node.contains("extensions")) continue;
      for (Json& accessor : node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]) accessor = Copied(accessor);
    }
    if (out_.json.contains("skins")) {
      for (Json& skin : out_.json["skins"]) skin["inverseBindMatrices"] = Copied(skin["inverseBindMatrices"]);
    }
  }

  std::size_t Copied(std::size_t accessor) {
    const Json& from = plain_.json["accessors"][accessor];
    Json to = from;
    to.erase("byteOffset");
    const std::size_t width = from["type"] == "MAT4" ? 16 : from["type"] == "VEC4" ? 4 : 3;
    const std::size_t bytes = 4 * width * from["count"].get<std::size_t>();
    const Json& view = plain_.json["bufferViews"][from["bufferView"].get<std::size_t>()];
    const std::size_t at = view.value("byteOffset", std::size_t{0}) + from.value("byteOffset", std::size_t{0});
    return AddAccessor(out_, plain_.bin.substr(at, bytes), to);
  }

  // What moves each mesh undoes its grid.
  void PlaceMeshes() {
    if (!Integers()) return;
    for (std::size_t i = 0, nodes = out_.json["nodes"].size(); i < nodes; ++i) {
      Json& node = out_.json["nodes"][i];
      if (!node.contains("mesh")) continue;
      const Grid& grid = grids_[node["mesh"].get<std::size_t>()];
      if (node.contains("skin")) {
        Edit<glm::mat4>(out_.json["skins"][node["skin"].get<std::size_t>()]["inverseBindMatrices"], [&](auto& inverse) {
          inverse[3] = inverse * glm::vec4(glm::vec3(grid.offset), 1);
          for (int c = 0; c < 3; ++c) inverse[c] *= static_cast<float>(grid.scale);
        });
      } else if (node.contains("extensions")) {
        MoveInstances(node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"], grid);
      } else {
        const Json child = {{"mesh", node["mesh"]},
                            {"translation", {grid.offset.x, grid.offset.y, grid.offset.z}},
                            {"scale", {grid.scale, grid.scale, grid.scale}}};
        node.erase("mesh");
        node["children"].push_back(nodes + children_++);
        out_.json["nodes"].push_back(child);
      }
    }
  }

  // Each element of an accessor that is already written.
  template <class T, class Change>
  void Edit(std::size_t accessor, Change change) {
    const Json& json = out_.json["accessors"][accessor];
    char* const at = &out_.bin[out_.json["bufferViews"][json["bufferView"].get<std::size_t>()]["byteOffset"]];
    for (std::size_t i = 0; i < json["count"].get<std::size_t>(); ++i) {
      T value;
      std::memcpy(&value, at + i * sizeof(T), sizeof(T));
      change(value);
      std::memcpy(at + i * sizeof(T), &value, sizeof(T));
    }
  }

  // T R S (offset + scale x) = (T + R S offset) R (scale S) x
  void MoveInstances(const Json& attributes, const Grid& grid) {
    std::vector<glm::vec4> turns;
    std::vector<glm::vec3> scales;
    Edit<glm::vec4>(attributes["ROTATION"], [&](const glm::vec4& turn) { turns.push_back(turn); });
    Edit<glm::vec3>(attributes["SCALE"], [&](glm::vec3& scale) {
      scales.push_back(scale);
      scale *= static_cast<float>(grid.scale);
    });
    std::size_t i = 0;
    Edit<glm::vec3>(attributes["TRANSLATION"], [&](glm::vec3& place) {
      place += glm::quat(turns[i].w, turns[i].x, turns[i].y, turns[i].z) * (scales[i] * glm::vec3(grid.offset));
      ++i;
    });
  }

  void WriteMesh(std::size_t mesh) {
    out_.json["meshes"].push_back({{"primitives", Json::array()}});
    for (const Part& part : meshes_[mesh]) {
      Json primitive = {{"attributes", Json::object()}};
      if (style_.packing == Packing::kDraco) {
        out_.json["meshes"].back()["primitives"].push_back(primitive);
        WriteDraco(part, out_.json["meshes"].back()["primitives"].back());
        continue;
      }
      primitive["attributes"]["POSITION"] = style_.sparse ? SparsePositions(part) : Positions(part, grids_[mesh]);
      if (!part.joints.empty()) {
        primitive["attributes"]["JOINTS_0"] = Add("joints", Bytes(part.joints), 4, 5121, "VEC4");
        primitive["attributes"]["WEIGHTS_0"] = Add("weights", Bytes(part.weights), 16, 5126, "VEC4");
      }
      primitive["indices"] = index_bytes_ == 4 ? Add("indices", Bytes(part.corners), 4, 5125)
                                               : Add("indices", Bytes(Short(part.corners)), 2, 5123);
      out_.json["meshes"].back()["primitives"].push_back(std::move(primitive));
    }
  }

  std::size_t Positions(const Part& part, const Grid& grid) {
    std::string bytes = Bytes(part.positions);
    if (style_.exponents) {
      meshopt_encodeFilterExp(bytes.data(), part.positions.size(), 12, style_.bits, part.positions.data()->data());
      return Add("positions", bytes, 12, 5126, "VEC3");
    }
    if (!Integers()) return Add("positions", bytes, 12, 5126, "VEC3");
    std::vector<std::array<std::int16_t, 4>> stored;
    for (const Position& p : part.positions) {
      const glm::dvec3 share = (glm::dvec3(p[0], p[1], p[2]) - grid.offset) / grid.scale;
      auto& row = stored.emplace_back();
      for (int c = 0; c < 3; ++c)
        row[static_cast<std::size_t>(c)] =
            static_cast<std::int16_t>(std::lround(style_.normalized ? 32767 * share[c] : share[c]));
    }
    const std::size_t accessor = Add("positions", Bytes(stored), 8, style_.normalized ? 5122 : 5123, "VEC3");
    if (style_.normalized) out_.json["accessors"][accessor]["normalized"] = true;
    return accessor;
  }

  // Each third vertex replaces one at the origin.
  std::size_t SparsePositions(const Part& part) {
    std::vector<Position> base = part.positions, values;
    std::vector<std::uint16_t> changed;
    for (std::size_t i = 0; i < base.size(); i += 3) {
      changed.push_back(static_cast<std::uint16_t>(i));
      values.push_back(std::exchange(base[i], Position{}));
    }
    const std::size_t accessor = Add("positions", Bytes(base), 12, 5126, "VEC3");
    const auto view = [&](const std::string& bytes) {
      const std::size_t at = Append(out_, bytes);
      out_.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", at}, {"byteLength", bytes.size()}});
      return out_.json["bufferViews"].size() - 1;
    };
    out_.json["accessors"][accessor]["sparse"] = {
        {"count", changed.size()},
        {"indices", {{"bufferView", view(Bytes(changed))}, {"componentType", 5123}}},
        {"values", {{"bufferView", view(Bytes(values))}}}};
    return accessor;
  }

  // An accessor of the next values of a stream.
  std::size_t Add(const char* kind, const std::string& bytes, std::size_t stride, int component,
                  const char* type = "SCALAR") {
    const bool indices = type == std::string("SCALAR");
    const auto [place, fresh] = streams_.try_emplace(kind);
    Stream& stream = place->second;
    if (fresh) {
      stream.view = out_.json["bufferViews"].size();
      stream.stride = stride;
      if (indices) stream.mode = "TRIANGLES";
      out_.json["bufferViews"].push_back({{"buffer", 0}});
      if (Integers() && stride == 8) out_.json["bufferViews"].back()["byteStride"] = stride;
    }
    out_.json["accessors"].push_back({{"bufferView", stream.view},
                                      {"byteOffset", stream.bytes.size()},
                                      {"componentType", component},
                                      {"count", bytes.size() / stride},
                                      {"type", type}});
    stream.bytes += bytes;
    return out_.json["accessors"].size() - 1;
  }

  void WriteDraco(const Part& part, Json& primitive) {
    std::vector<DracoAttribute> attributes{
        {"POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, Bytes(part.positions)}};
    if (!part.joints.empty()) {
      attributes.push_back({"JOINTS_0", draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 4, Bytes(part.joints)});
      attributes.push_back({"WEIGHTS_0", draco::GeometryAttribute::GENERIC, draco::DT_FLOAT32, 4, Bytes(part.weights)});
    }
    std::vector<std::array<std::uint32_t, 3>> triangles(part.corners.size() / 3);
    for (std::size_t i = 0; i < part.corners.size(); ++i) triangles[i / 3][i % 3] = part.corners[i];
    const std::string encoded = EncodeDraco(triangles, part.positions.size(), attributes, true, style_.bits);
    const auto [corners, vertices] = DracoCounts(encoded);
    Json& accessors = out_.json["accessors"];
    for (const DracoAttribute& attribute : attributes) {
      primitive["attributes"][attribute.name] = accessors.size();
      accessors.push_back({{"componentType", attribute.data == draco::DT_UINT8 ? 5121 : 5126},
                           {"count", vertices},
                           {"type", attribute.width == 3 ? "VEC3" : "VEC4"}});
    }
    primitive["indices"] = accessors.size();
    accessors.push_back({{"componentType", 5125}, {"count", corners}, {"type", "SCALAR"}});
    UseDraco(out_, encoded, attributes, primitive);
  }

  static std::vector<std::uint16_t> Short(const std::vector<unsigned>& corners) {
    return {corners.begin(), corners.end()};
  }

  static std::vector<unsigned> Corners(const Stream& stream) {
    std::vector<unsigned> corners(stream.bytes.size() / stream.stride);
    for (std::size_t i = 0; i < corners.size(); ++i)  // the least byte is the first one
      std::memcpy(&corners[i], &stream.bytes[i * stream.stride], stream.stride);
    return corners;
  }

  void WriteStreams() {
    for (const auto& [kind, stream] : streams_) {
      const std::size_t count = stream.bytes.size() / stream.stride;
      if (style_.packing == Packing::kViews) {
        const std::string encoded =
            kind == "indices" ? MeshoptIndices(Corners(stream), true) : MeshoptVertices(stream.bytes, stream.stride);
        const bool filtered = kind == "positions" && style_.exponents;
        Compress(out_, stream.view, encoded, count, stream.stride, stream.mode, filtered ? "EXPONENTIAL" : nullptr);
        if (style_.fallback) KeepUncompressed(stream);
      } else {
        Json& view = out_.json["bufferViews"][stream.view];
        view["byteOffset"] = Append(out_, stream.bytes);
        view["byteLength"] = stream.bytes.size();
      }
    }
    if (style_.fallback) out_.json.erase("extensionsRequired");
    if (Integers()) {
      out_.json["extensionsUsed"].push_back("KHR_mesh_quantization");
      out_.json["extensionsRequired"].push_back("KHR_mesh_quantization");
    }
  }

  void KeepUncompressed(const Stream& stream) {
    fallback_.resize((fallback_.size() + 3) / 4 * 4, '\0');
    out_.json["bufferViews"][stream.view]["byteOffset"] = fallback_.size();
    fallback_ += stream.bytes;
    out_.json["buffers"][1]["byteLength"] = fallback_.size();
    out_.json["buffers"][1]["uri"] = kFallbackFile;
  }

  const Model& plain_;
  const Style style_;
  Model out_;
  std::vector<std::vector<Part>> meshes_;
  std::vector<Grid> grids_;  // of each mesh
  std::size_t children_ = 0, index_bytes_ = 2;
  std::map<std::string, Stream> streams_;
  std::string fallback_;
};

}  // namespace omni::scene::test
