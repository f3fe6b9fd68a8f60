// The tree over the triangles of one object: eight float boxes per node, four triangles per leaf. All of it only
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
inline constexpr int kLeafSize = 4;
inline constexpr int kMaxTreeDepth =
    24;  // nodes from root to leaf, guaranteed by tree_build.cc: stacks in the tick are fixed

// What a child is: the index of an inner node, or a leaf. Unused children have boxes that nothing intersects.
inline constexpr std::uint32_t kLeafBit = 0x80000000;   // the rest is a LeafRange, or what a view makes of it
inline constexpr std::uint32_t kMovesBit = 0x40000000;  // leaf: its triangles can leave their rest place, not its box
inline constexpr std::uint32_t kChildIndex = 0x3FFFFFFF;
inline constexpr std::uint32_t kNoChild = 0xFFFFFFFF;

// A leaf of consecutive triangles, which are numbered in the order of the leaves.
struct LeafRange {
  std::uint32_t first = 0;  // below 2^28
  std::uint32_t count = 1;  // 1 to kLeafSize
  bool moves = false;

  static constexpr LeafRange Of(std::uint32_t child) noexcept {
    return {(child & kChildIndex) / kLeafSize, child % kLeafSize + 1, (child & kMovesBit) != 0};
  }
  constexpr std::uint32_t Child() const noexcept {
    return kLeafBit | (moves ? kMovesBit : 0) | (first * kLeafSize + count - 1);
  }
  constexpr unsigned LaneMask() const noexcept { return (1U << count) - 1; }  // one bit per triangle
};

// Base frame, m; rounded outwards and large enough for every place a triangle can take.
struct alignas(32) TreeNode {
  float lower[3][kTreeWidth];
  float upper[3][kTreeWidth];
  std::uint32_t child[kTreeWidth];
};

static_assert(sizeof(TreeNode) == 224);

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

// Appends the tree to `nodes` and returns its root. On return `primitives` are in the order of the leaves, which count
// them from `first` on. Precondition: 1 to 4 million primitives, finite.
BuiltTree AppendTree(std::span<TreePrimitive> primitives, std::uint32_t first, std::vector<TreeNode>& nodes,
                     const base::WorkWatch& watch = {});

}  // namespace omni::haptics
