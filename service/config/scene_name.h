// The file that a scene's name means, wherever one is named: commands, application files, scene_render.
#pragma once

#include <string>

#include "service/base/result.h"

namespace omni::config {

// The first that is there of `name` itself, with ".glb" and with ".gltf" behind it; as a path, then in
// `scenes_folder` (config::ScenesFolder()). "dragon" and "dragon.glb" are both the shipped dragon. The error says where
// it was looked for, and the nearest name there.
base::Result<std::string> FindScene(const std::string& name, const std::string& scenes_folder);

}  // namespace omni::config
