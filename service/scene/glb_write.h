// What every writer of .glb files needs: the container, numbers of tags, normals.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

// Appends 32 bits, little endian.
void PutWord(std::size_t value, std::string& to);

// Header, JSON chunk and `chunks`: whole ones, may be empty.
std::string GlbFile(std::string json, std::string_view chunks);

// "softness.thickness" -> tag["softness"]["thickness"]. Json: nlohmann::json or ordered_json.
template <class Json>
void PutKey(std::string_view key, double value, Json& tag) {
  const std::size_t dot = key.find('.');
  if (dot == std::string_view::npos) {
    tag[std::string(key)] = value;
  } else {
    PutKey(key.substr(dot + 1), value, tag[std::string(key.substr(0, dot))]);
  }
}

// Area-weighted; (0, 0, 1) where there is none.
std::vector<base::Vec3> VertexNormals(const haptics::InputObject& object);

}  // namespace omni::scene
