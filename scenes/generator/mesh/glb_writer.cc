#include "scenes/generator/mesh/glb_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace omni::scenes {
namespace {

constexpr int kFloat = 5126, kUnsignedByte = 5121, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

Vec ToGltf(const Vec& p) { return {p.x, p.z, -p.y + 0.0}; }

class Writer {
 public:
  explicit Writer(const Document& document) : document_(document) {}

  std::vector<unsigned char> Run() {
    OrderedJson root;
    root["asset"] = {{"version", "2.0"}, {"generator", "omni scene_generator"}, {"copyright", "Apache-2.0"}};
    if (!document_.extensions_used.empty()) root["extensionsUsed"] = document_.extensions_used;
    root["scene"] = 0;
    root["scenes"] = OrderedJson::array({{{"name", document_.title}, {"nodes", Roots()}}});
    root["nodes"] = OrderedJson::array();
    for (const OutNode& node : document_.nodes) root["nodes"].push_back(Node(node));
    root["materials"] = OrderedJson::array();
    for (const OutMaterial& material : document_.materials) root["materials"].push_back(Material(material));
    root["meshes"] = OrderedJson::array();
    for (const OutMesh& mesh : document_.meshes) root["meshes"].push_back(MeshOf(mesh));
    root["accessors"] = accessors_;
    root["bufferViews"] = views_;
    root["buffers"] = OrderedJson::array({{{"byteLength", bytes_.size()}}});
    if (!document_.extensions.is_null()) root["extensions"] = document_.extensions;
    return Glb(root.dump());
  }

 private:
  std::vector<std::uint32_t> Roots() const {
    std::vector<bool> child(document_.nodes.size(), false);
    for (const OutNode& node : document_.nodes) {
      for (const std::uint32_t c : node.children) child[c] = true;
    }
    std::vector<std::uint32_t> roots;
    for (std::uint32_t i = 0; i < child.size(); ++i) {
      if (!child[i]) roots.push_back(i);
    }
    return roots;
  }

  static OrderedJson Node(const OutNode& node) {
    OrderedJson json = {{"name", node.name}};
    if (node.mesh) json["mesh"] = *node.mesh;
    const Vec t = ToGltf(node.translation_base_m);
    if (t != Vec(0.0)) json["translation"] = {Rounded(t.x), Rounded(t.y), Rounded(t.z)};
    if (node.heading_rad != 0) {
      json["rotation"] = {0, Rounded(std::sin(node.heading_rad / 2)), 0, Rounded(std::cos(node.heading_rad / 2))};
    }
    if (!node.children.empty()) json["children"] = node.children;
    if (!node.haptic.is_null()) json["extras"] = {{"haptic", node.haptic}};
    return json;
  }

  static OrderedJson Material(const OutMaterial& material) {
    OrderedJson json = {{"name", material.name}};
    json["pbrMetallicRoughness"] = {
        {"baseColorFactor", {Rounded(material.colour.x), Rounded(material.colour.y), Rounded(material.colour.z), 1}},
        {"metallicFactor", material.metallic},
        {"roughnessFactor", material.roughness}};
    if (!material.extensions.is_null()) json["extensions"] = material.extensions;
    if (!material.extras.is_null()) json["extras"] = material.extras;
    return json;
  }

  static double Rounded(double value) { return std::nearbyint(value * 1e6) / 1e6 + 0.0; }

  OrderedJson MeshOf(const OutMesh& mesh) {
    OrderedJson attributes;
    std::vector<float> positions;
    for (const Vec& p : mesh.mesh.positions) Push(positions, ToGltf({Quantised(p.x), Quantised(p.y), Quantised(p.z)}));
    attributes["POSITION"] = Floats(positions, true);
    std::vector<float> normals;
    for (const Vec& n : VertexNormals(mesh.mesh)) {
      Push(normals,
           glm::dvec3(ToGltf({std::nearbyint(n.x * 1024), std::nearbyint(n.y * 1024), std::nearbyint(n.z * 1024)})) /
               1024.0);
    }
    attributes["NORMAL"] = Floats(normals, false);
    if (!mesh.mesh.colours.empty()) attributes["COLOR_0"] = Colours(mesh.mesh.colours);
    OrderedJson primitives = OrderedJson::array();
    for (std::uint32_t group = 0; group < mesh.materials.size(); ++group) {
      OrderedJson primitive = {{"attributes", attributes}, {"indices", Indices(mesh.mesh, group)}};
      primitive["material"] = mesh.materials[group];
      primitives.push_back(primitive);
    }
    OrderedJson json = {{"name", mesh.name}, {"primitives", primitives}};
    if (!mesh.extensions.is_null()) json["extensions"] = mesh.extensions;
    return json;
  }

  static void Push(std::vector<float>& to, const Vec& v) {
    for (const double c : {v.x, v.y, v.z}) to.push_back(static_cast<float>(c + 0.0));
  }

  std::size_t AddView(const void* data, std::size_t bytes, int target) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4, 0);
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}, {"target", target}});
    const auto* from = static_cast<const unsigned char*>(data);
    bytes_.insert(bytes_.end(), from, from + bytes);
    return views_.size() - 1;
  }

  std::size_t Floats(const std::vector<float>& values, bool bounds) {
    OrderedJson accessor = {{"bufferView", AddView(values.data(), values.size() * sizeof(float), kArrayBuffer)},
                            {"componentType", kFloat},
                            {"count", values.size() / 3},
                            {"type", "VEC3"}};
    if (bounds) {
      std::vector<double> lower(3, 1e9), upper(3, -1e9);
      for (std::size_t i = 0; i < values.size(); ++i) {
        lower[i % 3] = std::min(lower[i % 3], static_cast<double>(values[i]));
        upper[i % 3] = std::max(upper[i % 3], static_cast<double>(values[i]));
      }
      accessor["min"] = lower;
      accessor["max"] = upper;
    }
    accessors_.push_back(accessor);
    return accessors_.size() - 1;
  }

  std::size_t Colours(const std::vector<Vec>& colours) {
    std::vector<unsigned char> values;
    for (const Vec& colour : colours) {
      for (const double c : {colour.x, colour.y, colour.z, 1.0}) {
        values.push_back(static_cast<unsigned char>(std::nearbyint(std::clamp(c, 0.0, 1.0) * 255)));
      }
    }
    accessors_.push_back({{"bufferView", AddView(values.data(), values.size(), kArrayBuffer)},
                          {"componentType", kUnsignedByte},
                          {"normalized", true},
                          {"count", colours.size()},
                          {"type", "VEC4"}});
    return accessors_.size() - 1;
  }

  std::size_t Indices(const Mesh& mesh, std::uint32_t group) {
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const std::uint32_t own = mesh.groups.empty() ? 0 : mesh.groups[i];
      if (own == group) indices.insert(indices.end(), mesh.triangles[i].begin(), mesh.triangles[i].end());
    }
    const bool is_short = mesh.positions.size() < 65535;
    std::vector<std::uint16_t> shorts;
    if (is_short) {
      for (const std::uint32_t index : indices) shorts.push_back(static_cast<std::uint16_t>(index));
    }
    const std::size_t view = is_short ? AddView(shorts.data(), shorts.size() * 2, kElementArrayBuffer)
                                      : AddView(indices.data(), indices.size() * 4, kElementArrayBuffer);
    accessors_.push_back({{"bufferView", view},
                          {"componentType", is_short ? kUnsignedShort : kUnsignedInt},
                          {"count", indices.size()},
                          {"type", "SCALAR"}});
    return accessors_.size() - 1;
  }

  std::vector<unsigned char> Glb(std::string text) const {
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const std::size_t bin = (bytes_.size() + 3) / 4 * 4;
    std::vector<unsigned char> glb(28 + text.size() + bin, 0);
    const auto put = [&glb](std::size_t at, std::size_t value) {
      for (std::size_t i = 0; i < 4; ++i) glb[at + i] = static_cast<unsigned char>(value >> (8 * i) & 0xFF);
    };
    put(0, 0x46546C67);  // "glTF"
    put(4, 2);
    put(8, glb.size());
    put(12, text.size());
    put(16, 0x4E4F534A);  // "JSON"
    std::memcpy(&glb[20], text.data(), text.size());
    put(20 + text.size(), bin);
    put(24 + text.size(), 0x004E4942);  // "BIN"
    std::memcpy(&glb[28 + text.size()], bytes_.data(), bytes_.size());
    return glb;
  }

  const Document& document_;
  std::vector<unsigned char> bytes_;
  OrderedJson accessors_ = OrderedJson::array();
  OrderedJson views_ = OrderedJson::array();
};

}  // namespace

std::vector<unsigned char> WriteGlb(const Document& document) { return Writer(document).Run(); }

}  // namespace omni::scenes
