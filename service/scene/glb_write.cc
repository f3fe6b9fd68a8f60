#include "service/scene/glb_write.h"

#include <cmath>

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

}  // namespace omni::scene
