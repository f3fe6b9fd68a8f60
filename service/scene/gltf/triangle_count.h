// How many triangles and primitives a document has, by the counts of its accessors: known before any of them is read.
#pragma once

#include <vector>

#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/node_tree.h"

namespace omni::scene {

// Throws LoadError when the meshes of `nodes`, each of which has one, have more than haptics::kMaxTriangles with all
// their instances, or 400,000 primitives.
void CheckTriangleCount(const Json& root, const std::vector<const NodeVisit*>& nodes);

}  // namespace omni::scene
