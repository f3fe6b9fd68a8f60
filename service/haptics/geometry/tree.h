// The tree over the triangles of one object: eight float boxes per node, four float triangles per leaf. All of it only
// excludes; what is left is decided in double on the mesh itself. docs/theory/haptics.md, section 1.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "service/base/vec.h"
#include "service/base/work_watch.h"

namespace omni::haptics {

using base::Vec3;

inline constexpr int kTreeWidth = 8;
inline constexpr int kPacketSize = 4;
inline constexpr int kMaxTreeDepth =
    24;  // nodes from root to leaf, guaranteed by tree_build.cc: stacks in the tick are fixed

// What a child is: an inner node, or a leaf (a packet). Unused children have boxes that nothing intersects.
inline constexpr std::uint32_t kLeafBit = 0x80000000;   // the rest is the index of a packet, else of a node
inline constexpr std::uint32_t kMovesBit = 0x40000000;  // leaf: its triangles can leave their rest place, not its box
inline constexpr std::uint32_t kChildIndex = 0x3FFFFFFF;
inline constexpr std::uint32_t kNoChild = 0xFFFFFFFF;

// Base frame, m; rounded outwards and large enough for every place a triangle can take.
struct alignas(32) TreeNode {
  float lower[3][kTreeWidth];
  float upper[3][kTreeWidth];
  std::uint32_t child[kTreeWidth];
};

// Rest corners [axis][triangle], rounded to nearest. A packet with fewer triangles repeats its first.
struct alignas(16) TrianglePacket {
  float corner[3][3][kPacketSize];  // [corner][axis][triangle]
  std::uint32_t triangle[kPacketSize];
};

static_assert(sizeof(TreeNode) == 224 && sizeof(TrianglePacket) == 160);

// Its building (tree_build.cc): binned surface-area heuristic in float, depth at most kMaxTreeDepth, one thread, memory
// linear. Deterministic. Set-up only.
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
                     std::vector<TrianglePacket>& packets, const base::WorkWatch& watch = {});

// Corner k of the triangle in `lane`, rounded to float.
inline void FillPacket(TrianglePacket& packet, int lane, int k, const Vec3& corner) {
  packet.corner[k][0][lane] = static_cast<float>(corner.x);
  packet.corner[k][1][lane] = static_cast<float>(corner.y);
  packet.corner[k][2][lane] = static_cast<float>(corner.z);
}

}  // namespace omni::haptics
