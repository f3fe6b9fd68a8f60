#include "scenes/generator/glb_reader.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace omni::scenes {
namespace {

using Json = nlohmann::json;

class Reader {
 public:
  explicit Reader(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(file), {});
    if (bytes_.size() < 28 || std::memcmp(bytes_.data(), "glTF", 4) != 0)
      throw std::runtime_error(path + ": no binary glTF");
    const std::size_t json_bytes = At<std::uint32_t>(12);
    if (json_bytes > bytes_.size() - 28) throw std::runtime_error(path + ": is truncated");
    root_ = Json::parse(bytes_.begin() + 20, bytes_.begin() + 20 + static_cast<std::ptrdiff_t>(json_bytes));
    bin_ = 28 + json_bytes;
  }

  std::vector<DrawnMesh> Run() {
    for (const Json& node : root_.at("nodes")) {
      if (!node.contains("mesh")) continue;
      for (const Json& primitive : root_.at("meshes").at(node["mesh"].get<std::size_t>()).at("primitives"))
        Draw(node, primitive);
    }
    return std::move(drawn_);
  }

 private:
  template <class T>
  T At(std::size_t offset) const {
    T value;
    if (offset + sizeof value > bytes_.size()) throw std::runtime_error("accessor beyond the end of the file");
    std::memcpy(&value, &bytes_[offset], sizeof value);
    return value;
  }

  // Offset of an accessor's first byte, its count.
  std::pair<std::size_t, std::size_t> Range(const Json& accessor) const {
    const Json& view = root_.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
    return {bin_ + view.value("byteOffset", std::size_t{0}) + accessor.value("byteOffset", std::size_t{0}),
            accessor.at("count").get<std::size_t>()};
  }

  std::vector<Vec> Vectors(const Json& attributes, const char* key, bool bytes) const {
    const auto [offset, count] = Range(root_.at("accessors").at(attributes.at(key).get<std::size_t>()));
    std::vector<Vec> vectors;
    for (std::size_t i = 0; i < count; ++i) {
      Vec v;
      for (int k = 0; k < 3; ++k) {
        const std::size_t c = static_cast<std::size_t>(k);
        v[k] = bytes ? At<std::uint8_t>(offset + 4 * i + c) / 255.0
                     : static_cast<double>(At<float>(offset + 12 * i + 4 * c));
      }
      vectors.push_back(v);
    }
    return vectors;
  }

  void Draw(const Json& node, const Json& primitive) {
    DrawnMesh drawn;
    drawn.name = node.value("name", "");
    const Json& attributes = primitive.at("attributes");
    const Json t = node.value("translation", Json{0.0, 0.0, 0.0}), q = node.value("rotation", Json{0.0, 0.0, 0.0, 1.0});
    const glm::dquat rotation(q[3].get<double>(), q[0].get<double>(), q[1].get<double>(), q[2].get<double>());
    const Vec shift(t[0].get<double>(), t[1].get<double>(), t[2].get<double>());
    const auto to_base = [](const Vec& p) { return Vec(p.x, -p.z, p.y); };
    for (const Vec& p : Vectors(attributes, "POSITION", false))
      drawn.mesh.positions.push_back(to_base(rotation * p + shift));
    for (const Vec& n : Vectors(attributes, "NORMAL", false)) drawn.normals.push_back(to_base(rotation * n));
    // Files of what was sculpted or deformed have no paint.
    const Json& material = root_.at("materials").at(primitive.at("material").get<std::size_t>());
    const Json pbr = material.value("pbrMetallicRoughness", Json::object());
    const Json factor = pbr.value("baseColorFactor", Json{0.5, 0.5, 0.5, 1.0});
    const Vec colour(factor[0].get<double>(), factor[1].get<double>(), factor[2].get<double>());
    drawn.roughness = pbr.value("roughnessFactor", 0.7);
    drawn.mesh.colours.assign(drawn.mesh.positions.size(), colour);
    if (attributes.contains("COLOR_0")) drawn.mesh.colours = Vectors(attributes, "COLOR_0", true);
    const Json& accessor = root_.at("accessors").at(primitive.at("indices").get<std::size_t>());
    const bool is_short = accessor.at("componentType") == 5123;
    const auto [offset, count] = Range(accessor);
    for (std::size_t i = 0; i + 2 < count; i += 3) {
      Triangle triangle;
      for (std::size_t k = 0; k < 3; ++k) {
        triangle[k] = is_short ? At<std::uint16_t>(offset + 2 * (i + k)) : At<std::uint32_t>(offset + 4 * (i + k));
        if (triangle[k] >= drawn.mesh.positions.size()) throw std::runtime_error("index beyond the vertices");
      }
      drawn.mesh.triangles.push_back(triangle);
    }
    drawn_.push_back(std::move(drawn));
  }

  std::vector<char> bytes_;
  Json root_;
  std::size_t bin_ = 0;
  std::vector<DrawnMesh> drawn_;
};

}  // namespace

std::vector<DrawnMesh> ReadGlb(const std::string& path) { return Reader(path).Run(); }

}  // namespace omni::scenes
