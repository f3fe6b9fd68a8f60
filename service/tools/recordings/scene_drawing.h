// A scene as a picture of a run shows it: the triangles that are seen from one side, shaded, the furthest first.
#pragma once

#include <vector>

#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"

namespace omni::tools {

// An orthographic view. right, up: unit, at right angles; what is seen is within half_m of the centre.
struct SceneView {
  base::Vec3 centre_m, right, up;
  double half_m = 0.05;
};

struct DrawnTriangle {
  base::Vec3 corners_m[3];
  double brightness = 1;  // 0 to 1: of the side that is seen
};

// What covers no cell of a grid of `cells` x `cells` over the view is left out.
std::vector<DrawnTriangle> SeenTriangles(const haptics::Scene& scene, const SceneView& view, int cells);

}  // namespace omni::tools
