// The walls a car meets, as segments in the plane it drives on, and queries on them. Exact; no allocation; any speed.
// docs/theory/haptics.md, section 8.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "service/base/vec.h"
#include "service/base/work_watch.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_block.h"

namespace omni::haptics {

using base::Vec3;

inline constexpr int kMaxWallDepth = 40;  // of the tree: guaranteed by BuildWalls, which halves the segments

// View of a scene's walls; the scene outlives it. z of points is ignored and 0 in answers.
struct WallMap {
  std::span<const WallNode> nodes;  // empty: no walls
  std::span<const WallSegment> segments;
};
inline WallMap WallsOf(const Scene& scene) noexcept { return {scene.wall_nodes(), scene.wall_segments()}; }

struct Wall {
  bool found = false;
  double distance_m = 0;  // of the disc's centre
  Vec3 normal;            // horizontal, unit, from the wall to the centre
  std::uint32_t material = 0;
};

// Nearest wall to `p` that is nearer than `reach_m`.
Wall NearestWall(const WallMap& walls, const Vec3& p, double reach_m) noexcept;

struct WallTouch {
  bool found = false;
  double share = 1;  // of the motion until the touch, [0, 1]
  Vec3 normal;       // unit, from the wall to the centre at the touch
  std::uint32_t material = 0;
  bool overlaps = false;  // a wall, where the motion begins
};

// First touch of a disc of `radius_m` that moves from `p` by `motion`: the first place from where going on would bring
// its centre nearer to a wall than the radius. A wall it overlaps already touches at once, if the motion goes deeper;
// it may always leave. Walls have no front: a disc is kept on the side its centre is on.
WallTouch FirstTouch(const WallMap& walls, const Vec3& p, const Vec3& motion, double radius_m) noexcept;

// Cuts the objects marked as car walls with the plane the car drives on, once, when a scene is built (wall_build.cc).
// Fills parts.wall_segments and parts.wall_nodes. A corner is below the plane or not, and edges between the two kinds
// are cut, so closed meshes give closed outlines; ground below the plane is not cut. Extruded walls count as at rest.
void BuildWalls(SceneParts& parts, const base::WorkWatch& watch);

// A car that starts inside a wall could never move, one without walls never hits, a checkpoint inside a wall cannot be
// passed: one line each, for people.
std::vector<std::string> ExplainWalls(const Scene& scene);

}  // namespace omni::haptics
