// EXT_mesh_gpu_instancing: a node's mesh in many places; and how many triangles that makes, by the counts of accessors:
// known before any of them is read.
#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <map>
#include <vector>

#include "service/scene/gltf/gltf_decode.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/node_tree.h"

namespace omni::scene {

inline constexpr const char* kInstancingExtension = "EXT_mesh_gpu_instancing";

bool IsInstanced(const Json& root, std::uint32_t node);

// How often a node's mesh is there; 1 without the extension. Throws LoadError.
std::uint64_t CountInstances(const Json& root, std::uint32_t node);

// Instances of nodes that have some.
using InstancesByNode = std::map<std::uint32_t, std::vector<Instance>>;

// The places of a primitive of the node's mesh, mesh -> scene, one per instance; what its joints have placed stays
// there. Throws LoadError.
std::vector<glm::dmat4> PlacesOf(const NodeVisit& node, const DecodedPrimitive& decoded,
                                 const InstancesByNode& instances);

// What a primitive has, by the counts of its accessors: corners name at most three vertices each, and bytes are those
// of positions and corners. Points and lines have none.
struct PrimitiveSize {
  std::uint64_t triangles = 0, vertices = 0, bytes = 0;
};
// Of a mesh. Throws LoadError.
std::vector<PrimitiveSize> SizesOf(const Json& root, std::uint32_t mesh);

// Bytes of an accessor's data in the file, whose elements take `packed` bytes; at most.
std::uint64_t StoredBytes(const Json& root, std::uint32_t accessor, std::uint64_t packed);

// Throws LoadError when the meshes of `nodes`, each of which has one, have more than haptics::kMaxTriangles with all
// their instances, or 400,000 primitives.
void CheckTriangleCount(const Json& root, const std::vector<const NodeVisit*>& nodes);

}  // namespace omni::scene
