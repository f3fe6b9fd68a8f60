// What queries, ring walks and the proxy require of a mesh. Any type with these may be touched: the flat mesh of a
// scene (surface.h), a mesh in pages. Indices are 32 bits and need not be dense.
#pragma once

#include <array>
#include <concepts>
#include <cstdint>

#include "service/haptics/geometry/tree_lanes.h"
#include "service/haptics/geometry/triangle_math.h"

namespace omni::haptics {

// view.GetTriangle(t) has vertex[3], neighbour[3] (across the edge k -> k + 1, kNoIndex: border) and component.
template <class View>
concept MeshView = requires(const View& view, std::uint32_t index) {
  { view.VertexPosition(index) }
  noexcept->std::same_as<Vec3>;
  { view.TriangleCorners(index) }
  noexcept->std::same_as<Corners>;
  { view.GetTriangle(index).vertex[0] } -> std::convertible_to<std::uint32_t>;
  { view.GetTriangle(index).neighbour[0] } -> std::convertible_to<std::uint32_t>;
  { view.GetTriangle(index).component } -> std::convertible_to<std::uint32_t>;
};

// A mesh with a tree over it, whose leaves are ranges of triangles or, where those are not numbered by leaves, lists of
// at most kLeafSize triangles.
template <class View>
concept LeafRangeView = requires(const View& view, const LeafRange& leaf) {
  { view.RestCorners(leaf) }
  noexcept->std::same_as<LeafCorners>;
};
template <class View>
concept LeafListView = requires(const View& view, std::array<std::uint32_t, kLeafSize>& triangles) {
  { view.LeafTriangles(std::uint32_t{}, triangles) }
  noexcept->std::same_as<int>;  // how many
};
template <class View>
concept TreeView = MeshView<View> &&(LeafRangeView<View> || LeafListView<View>)&&requires(const View& view) {
  { view.Node(std::uint32_t{}) }
  noexcept->std::same_as<const TreeNode&>;
  { view.TreeExtent() }
  noexcept->std::same_as<double>;  // largest |coordinate| of any box of the tree, m
};

}  // namespace omni::haptics
