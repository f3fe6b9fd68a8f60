// The tree of one page, made on the editor's side before the page is published.
#pragma once

#include "service/haptics/sculpt/mesh/boxes.h"

namespace omni::haptics::sculpt {

// Fills tree of pages[page] from the page's triangles, whose corners may lie in other pages. `keep_order`: only
// positions have changed since the last call, so the grouping stays and the boxes are refitted.
void BuildPageTree(const Page* const* pages, std::uint32_t page, bool keep_order, PageTree& tree) noexcept;

inline FloatBox BoxOf(const PageTree& tree) noexcept { return UnionOf(tree.top); }

}  // namespace omni::haptics::sculpt
