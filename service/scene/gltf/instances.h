// EXT_mesh_gpu_instancing: a node's mesh in many places.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <vector>

#include "service/scene/gltf/gltf_decode.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/node_tree.h"

namespace omni::scene {

inline constexpr const char* kInstancingExtension = "EXT_mesh_gpu_instancing";

bool IsInstanced(const Json& root, std::uint32_t node);

// How often a node's mesh is there; 1 without the extension. Throws LoadError.
std::uint64_t CountInstances(const Json& root, std::uint32_t node);

// Its transforms, mesh -> scene, one per instance. Throws LoadError.
std::vector<glm::dmat4> PlacesOf(const NodeVisit& node, const std::vector<Instance>& instances);

}  // namespace omni::scene
