// The tree over the triangles of one object: eight float boxes per node, four float triangles per leaf. All of it only
// excludes; what is left is decided in double on the mesh itself. docs/theory/haptics.md, section 1.
#pragma once

#include <cstdint>

namespace omni::haptics {

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

}  // namespace omni::haptics
