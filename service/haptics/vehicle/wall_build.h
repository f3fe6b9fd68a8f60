// Cuts the objects marked as car walls with the plane the car drives on, once, when a scene is built. Set-up only.
#pragma once

#include <string>
#include <vector>

#include "service/haptics/scene/scene_block.h"

namespace omni::haptics {

// Fills parts.wall_segments and parts.wall_nodes. A corner is below the plane or not, and edges between the two kinds
// are cut, so closed meshes give closed outlines; ground below the plane is not cut. Extruded walls count as at rest.
void BuildWalls(SceneParts& parts);

// A car that starts inside a wall could never move, one without walls never hits, a checkpoint inside a wall cannot be
// passed: one line each, for people.
std::vector<std::string> ExplainWalls(const Scene& scene);

}  // namespace omni::haptics
