#include "service/scene/glb_save.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "service/base/files/whole_file.h"
#include "service/scene/tags/haptic_keys.h"

namespace omni::scene {

using base::Vec3;

void PutWord(std::size_t value, std::string& to) {
  for (int shift = 0; shift < 32; shift += 8) to.push_back(static_cast<char>(value >> shift & 0xFF));
}

std::string GlbFile(std::string json, std::string_view chunks) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string glb = "glTF";
  PutWord(2, glb);
  PutWord(20 + json.size() + chunks.size(), glb);
  PutWord(json.size(), glb);
  glb += "JSON" + json;
  return glb.append(chunks);
}

std::vector<Vec3> VertexNormals(const haptics::InputObject& object) {
  std::vector<Vec3> normals(object.vertices_base_m.size());
  for (const auto& t : object.triangles) {
    const Vec3 &a = object.vertices_base_m[t[0]], &b = object.vertices_base_m[t[1]], &c = object.vertices_base_m[t[2]];
    const Vec3 n = Cross(b - a, c - a);
    for (const std::uint32_t k : t) normals[k] += n;
  }
  for (Vec3& n : normals) {
    const double length = std::hypot(n.x, n.y, n.z);
    n = length > 0 ? Vec3{n.x / length, n.y / length, n.z / length} : Vec3{0, 0, 1};
  }
  return normals;
}

namespace {

using base::Error;
using OrderedJson = nlohmann::ordered_json;

constexpr int kGlFloat = 5126, kGlUnsignedInt = 5125;
constexpr int kGlArrayBuffer = 34962, kGlElementArrayBuffer = 34963;

// Base frame (z up) -> glTF (y up): (x, y, z) -> (x, z, -y).
void PushGltf(const Vec3& v, std::vector<float>& to) {
  for (const double c : {v.x, v.z, -v.y}) to.push_back(static_cast<float>(c + 0.0));
}

OrderedJson TagOf(const haptics::Material& material) {
  OrderedJson tag = OrderedJson::object();
  const bool soft = material.softness.model != haptics::SoftnessModel::kNone;
  if (material.smooth) tag["smooth"] = true;
  if (soft) tag["softness"]["model"] = NameOf(kSoftnessModels, material.softness.model);
  if (material.sculpt.enabled) {
    tag["sculptable"]["falloff"] = NameOf(kFalloffs, material.sculpt.falloff);
    tag["sculptable"]["symmetry"] = NameOf(kSymmetries, material.sculpt.symmetry);
  }
  for (const base::MaterialField& field : base::kMaterialFields) {
    if (base::PartOf(field) == "softness" && !soft) continue;
    if (base::PartOf(field) == "extrude" && !material.extrude.enabled) continue;
    if (base::PartOf(field) == "sculptable" && !material.sculpt.enabled) continue;
    PutKey(field.key, field.Get(material), tag);
  }
  return tag;
}

std::string ProblemWith(const haptics::SceneInput& scene) {
  if (scene.joystick || scene.vehicle) return "a scene with a joystick or a vehicle is not saved";
  if (scene.objects.empty()) return "there is nothing to save";
  for (const haptics::InputObject& object : scene.objects) {
    if (object.triangles.size() != object.triangle_material.size()) return object.name + ": triangles without material";
    for (const std::uint16_t m : object.triangle_material) {
      if (m >= scene.materials.size()) return object.name + ": material index out of range";
    }
    for (const auto& t : object.triangles) {
      for (const std::uint32_t v : t) {
        if (v >= object.vertices_base_m.size()) return object.name + ": vertex index out of range";
      }
    }
    for (const Vec3& v : object.vertices_base_m) {
      if (!std::isfinite(static_cast<float>(v.x + v.y + v.z))) return object.name + ": a coordinate is not finite";
    }
  }
  return {};
}

class GlbWriter {
 public:
  explicit GlbWriter(const haptics::SceneInput& scene) : scene_(scene) {}

  std::string Run() {
    OrderedJson root;
    root["asset"] = {{"version", "2.0"}, {"generator", "omni"}};
    root["scene"] = 0;
    OrderedJson nodes = OrderedJson::array(), meshes = OrderedJson::array(), roots = OrderedJson::array();
    for (const haptics::InputObject& object : scene_.objects) {
      roots.push_back(nodes.size());
      nodes.push_back({{"name", object.name}, {"mesh", meshes.size()}, {"extras", {{"haptic", NodeTag(object)}}}});
      meshes.push_back({{"name", object.name}, {"primitives", Primitives(object)}});
    }
    root["scenes"] = OrderedJson::array({{{"name", scene_.name}, {"nodes", roots}}});
    root["nodes"] = nodes;
    root["meshes"] = meshes;
    root["materials"] = OrderedJson::array();
    for (const haptics::Material& material : scene_.materials) {
      root["materials"].push_back({{"extras", {{"haptic", TagOf(material)}}}});
    }
    root["accessors"] = accessors_;
    root["bufferViews"] = views_;
    root["buffers"] = OrderedJson::array({{{"byteLength", bytes_.size()}}});
    return File(root.dump(-1, ' ', false, OrderedJson::error_handler_t::replace));
  }

 private:
  static OrderedJson NodeTag(const haptics::InputObject& object) {
    OrderedJson tag = {{"role", object.car_wall ? "wall" : (object.collidable ? "solid" : "ignore")}};
    if (object.double_sided) tag["doubleSided"] = true;
    return tag;
  }

  OrderedJson Primitives(const haptics::InputObject& object) {
    std::vector<float> positions, normals;
    for (const Vec3& v : object.vertices_base_m) PushGltf(v, positions);
    for (const Vec3& n : VertexNormals(object)) PushGltf(n, normals);
    const std::size_t position = Floats(positions, true), normal = Floats(normals, false);
    OrderedJson primitives = OrderedJson::array();
    for (std::size_t m = 0; m < scene_.materials.size(); ++m) {
      std::vector<std::uint32_t> indices;
      for (std::size_t t = 0; t < object.triangles.size(); ++t) {
        if (object.triangle_material[t] != m) continue;
        indices.insert(indices.end(), object.triangles[t].begin(), object.triangles[t].end());
      }
      if (indices.empty()) continue;
      accessors_.push_back({{"bufferView", AddView(indices.data(), 4 * indices.size(), kGlElementArrayBuffer)},
                            {"componentType", kGlUnsignedInt},
                            {"count", indices.size()},
                            {"type", "SCALAR"}});
      primitives.push_back({{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                            {"indices", accessors_.size() - 1},
                            {"material", m}});
    }
    return primitives;
  }

  std::size_t AddView(const void* data, std::size_t bytes, int target) {
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes}, {"target", target}});
    bytes_.append(static_cast<const char*>(data), bytes);  // all of it is made of four-byte numbers
    return views_.size() - 1;
  }

  std::size_t Floats(const std::vector<float>& values, bool bounds) {
    OrderedJson accessor = {{"bufferView", AddView(values.data(), 4 * values.size(), kGlArrayBuffer)},
                            {"componentType", kGlFloat},
                            {"count", values.size() / 3},
                            {"type", "VEC3"}};
    if (bounds && !values.empty()) {
      std::vector<float> lower(values.begin(), values.begin() + 3), upper = lower;
      for (std::size_t i = 0; i < values.size(); ++i) {
        lower[i % 3] = std::min(lower[i % 3], values[i]);
        upper[i % 3] = std::max(upper[i % 3], values[i]);
      }
      accessor["min"] = lower;
      accessor["max"] = upper;
    }
    accessors_.push_back(accessor);
    return accessors_.size() - 1;
  }

  std::string File(std::string text) const {
    std::string binary;
    PutWord(bytes_.size(), binary);
    binary.append("BIN\0", 4);
    return GlbFile(std::move(text), binary + bytes_);
  }

  const haptics::SceneInput& scene_;
  std::string bytes_;
  OrderedJson accessors_ = OrderedJson::array();
  OrderedJson views_ = OrderedJson::array();
};

}  // namespace

base::Result<std::string> GlbBytes(const haptics::SceneInput& scene) {
  const std::string problem = ProblemWith(scene);
  if (!problem.empty()) return Error{problem};
  std::string bytes = GlbWriter(scene).Run();
  if (bytes.size() > 0xFFFFFFFF) return Error{"more than 4 GB, the limit of a .glb file; save fewer objects"};
  return bytes;
}

base::Status SaveGlb(const std::string& path, const haptics::SceneInput& scene) {
  const base::Result<std::string> bytes = GlbBytes(scene);
  if (!bytes.ok()) return Error{path + ": " + bytes.error()};
  return base::WriteWholeFile(path, *bytes);
}

}  // namespace omni::scene
