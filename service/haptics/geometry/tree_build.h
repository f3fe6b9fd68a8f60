// Builds the tree over the triangles of one object: binned surface-area heuristic in float, eight children per node,
// depth at most kMaxTreeDepth, one thread, memory linear. Deterministic. Set-up only.
#pragma once

#include <span>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/geometry/tree_node.h"

namespace omni::haptics {

using base::Vec3;

// A triangle as the builder sees it: its box, rounded outwards.
struct alignas(16) TreePrimitive {
  float lower[3];
  std::uint32_t triangle;
  float upper[3];
  std::uint32_t moves;  // 1: the box holds more than the rest place
};

// The box of `points`, grown by about one unit in the last place so that no rounding leaves anything outside.
TreePrimitive MakePrimitive(std::span<const Vec3> points, std::uint32_t triangle, bool moves);

struct BuiltTree {
  std::uint32_t root = 0;
  float lower[3]{}, upper[3]{};
};

// Appends the tree to `nodes` and `packets` and returns its root. Packets name triangles but hold no corners yet
// (FillPacket). On return `primitives` are in the order of the packets. Precondition: 1 to 4 million primitives,
// finite.
BuiltTree AppendTree(std::span<TreePrimitive> primitives, std::vector<TreeNode>& nodes,
                     std::vector<TrianglePacket>& packets);

// Corner k of the triangle in `lane`, rounded to float.
inline void FillPacket(TrianglePacket& packet, int lane, int k, const Vec3& corner) {
  packet.corner[k][0][lane] = static_cast<float>(corner.x);
  packet.corner[k][1][lane] = static_cast<float>(corner.y);
  packet.corner[k][2][lane] = static_cast<float>(corner.z);
}

}  // namespace omni::haptics
