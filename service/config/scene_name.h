// Finds the file of a scene by its name, for commands, application files and scene_render.
#pragma once

#include <string>

#include "service/base/result.h"

namespace omni::config {

// The first existing file of `name`, `name`.glb and `name`.gltf, as a path, then in `scenes_folder`
// (config::ScenesFolder()). "dragon" and "dragon.glb" are both the shipped dragon. The error names the folders that
// were searched, and the nearest name in them.
base::Result<std::string> FindScene(const std::string& name, const std::string& scenes_folder);

}  // namespace omni::config
