// Binary tree of float boxes over the triangles of one object (binned surface-area heuristic). Set-up only.
#pragma once

#include <vector>

#include "service/haptics/geometry/vec_math.h"
#include "service/haptics/scene.h"

namespace omni::haptics {

struct Box {
  Vec3 lower{1e30, 1e30, 1e30};
  Vec3 upper{-1e30, -1e30, -1e30};
  void Add(const Vec3& p) {
    lower = Min(lower, p);
    upper = Max(upper, p);
  }
  void Add(const Box& b) {
    lower = Min(lower, b.lower);
    upper = Max(upper, b.upper);
  }
};

// Appends the tree over `boxes` (one per triangle; triangle index = first_triangle + position) and returns its root.
// Leaves hold at most 4 triangles, depth stays below kMaxBvhDepth, boxes are rounded outwards. Precondition: boxes not
// empty.
std::uint32_t AppendBvh(const std::vector<Box>& boxes, std::uint32_t first_triangle, std::vector<BvhNode>& nodes,
                        std::vector<std::uint32_t>& leaf_triangles);

}  // namespace omni::haptics
