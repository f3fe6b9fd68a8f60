// Binary glTF files: a scene's solids as one that LoadSceneFile reads back, and what every writer of them needs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

// Saves positions, normals, indices, and the haptic tags of materials and nodes. For what was sculpted; no colours, no
// textures, no hierarchy.
// Writes every object as a node, each of its materials as a primitive with shared vertices. Positions are stored in
// single precision (at 0.1 m: 4 nm). The file appears whole or not at all. Fails with the path and the reason: a scene
// with a joystick or a vehicle (not of this kind), an index out of range, a coordinate that is not finite, no disk
// space.
base::Status SaveGlb(const std::string& path, const haptics::SceneInput& scene);

// The bytes of that file.
base::Result<std::string> GlbBytes(const haptics::SceneInput& scene);

// For every writer: the container, numbers of tags, normals.

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
