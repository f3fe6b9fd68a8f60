// A page: the piece of a sculpted mesh that is copied when an edit touches it. Up to 256 triangles and 160 vertices (a
// closed mesh has half as many vertices as triangles), with a small tree over its own triangles. Vertices and triangles
// are named by 32 bits: page = index >> 8, slot = index & 255; a slot may be free. docs/theory/sculpting.md, section 1.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/haptics/geometry/tree.h"
#include "service/haptics/geometry/triangle_math.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics::sculpt {

inline constexpr std::uint32_t kPageTriangles = 256;
inline constexpr std::uint32_t kPageVertices = 160;
inline constexpr std::uint32_t kPageFill = 224;        // triangles of a new page: the rest is room for splits
inline constexpr std::uint32_t kPageVertexFill = 136;  // vertices of a new page
inline constexpr std::uint32_t kMaxPages = 32768;      // 8 million triangles; further splits are refused
inline constexpr std::uint32_t kGroups = 64;           // leaves of a page's tree, at most kLeafSize triangles each

constexpr std::uint32_t PageOf(std::uint32_t index) noexcept { return index >> 8; }
constexpr std::uint32_t SlotOf(std::uint32_t index) noexcept { return index & 255; }
constexpr std::uint32_t IndexOf(std::uint32_t page, std::uint32_t slot) noexcept { return page << 8 | slot; }

// Nodes of the tree over pages and of the trees in them, as views number them (query.h): a node above the pages by its
// index in the table, a page's node, one of its eight groups; and leaves: a group's eighth, up to four triangles.
inline constexpr std::uint32_t kPageNode = 0x10000000;   // | page
inline constexpr std::uint32_t kGroupNode = 0x20000000;  // | page << 3 | group
constexpr std::uint32_t LeafOf(std::uint32_t page, std::uint32_t leaf) noexcept { return kLeafBit | page << 6 | leaf; }

// What an edit changes and undo restores, bit by bit. Free slots hold what EmptyPage() holds.
struct PageContent {
  Triangle triangle[kPageTriangles];
  Vec3 vertex[kPageVertices];                   // base frame, m
  std::uint32_t first_triangle[kPageVertices];  // one triangle that uses the vertex
  std::uint64_t triangle_used[kPageTriangles / 64];
  std::uint64_t vertex_used[(kPageVertices + 63) / 64];
  std::uint32_t triangle_count;
  std::uint32_t vertex_count;
  std::uint32_t spill;  // page that takes what does not fit here any more, or kNoIndex
  std::uint32_t reserved;
};
static_assert(std::is_trivially_copyable_v<PageContent> && sizeof(PageContent) % 8 == 0);

// Two levels of nodes. Leaf g holds order[GroupBegin(g)] ... order[GroupBegin(g + 1) - 1].
struct PageTree {
  TreeNode top;
  TreeNode group[8];
  std::uint8_t order[kPageTriangles];  // slots of the live triangles
  std::uint32_t count;
  constexpr std::uint32_t GroupBegin(std::uint32_t group_index) const noexcept { return group_index * count / kGroups; }
};

struct Page {
  PageContent content;
  PageTree tree;
};
static_assert(std::is_trivially_copyable_v<Page> && kPageTriangles == kGroups * kLeafSize);

inline bool UsesTriangle(const PageContent& page, std::uint32_t slot) noexcept {
  return (page.triangle_used[slot / 64] >> (slot % 64) & 1) != 0;
}
inline bool UsesVertex(const PageContent& page, std::uint32_t slot) noexcept {
  return slot < kPageVertices && (page.vertex_used[slot / 64] >> (slot % 64) & 1) != 0;
}

// The state of a page with nothing in it.
const Page& EmptyPage() noexcept;

// Reads vertices and triangles through a table of pages; a MeshView. The table outlives the view.
class PageView {
 public:
  explicit PageView(const Page* const* pages) noexcept : pages_(pages) {}

  Vec3 VertexPosition(std::uint32_t index) const noexcept {
    return pages_[PageOf(index)]->content.vertex[SlotOf(index)];
  }
  const Triangle& GetTriangle(std::uint32_t index) const noexcept {
    return pages_[PageOf(index)]->content.triangle[SlotOf(index)];
  }
  Corners TriangleCorners(std::uint32_t index) const noexcept {
    const Triangle& t = GetTriangle(index);
    return {VertexPosition(t.vertex[0]), VertexPosition(t.vertex[1]), VertexPosition(t.vertex[2])};
  }
  const Page& GetPage(std::uint32_t page) const noexcept { return *pages_[page]; }

 protected:
  const Page* const* pages_;
};

}  // namespace omni::haptics::sculpt
