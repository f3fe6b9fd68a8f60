// A scene's solids as a binary glTF file that LoadSceneFile reads back: positions, normals, indices, and the haptic
// tags of materials and nodes. For what was sculpted; no colours, no textures, no hierarchy.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

// Writes every object as a node, each of its materials as a primitive with shared vertices. Positions are stored in
// single precision (at 0.1 m: 4 nm). The file appears whole or not at all. Fails with the path and the reason: a scene
// with a joystick or a vehicle (not of this kind), an index out of range, a coordinate that is not finite, no disk
// space.
base::Status SaveGlb(const std::string& path, const haptics::SceneInput& scene);

// The bytes of that file.
base::Result<std::string> GlbBytes(const haptics::SceneInput& scene);

}  // namespace omni::scene
