// Force shading: the facets of a coarse mesh of a smooth body render as one smooth surface. Changes only the direction
// of a contact's force, never its magnitude or point. docs/theory/haptics.md, section 13.
#pragma once

#include <array>

#include "service/haptics/geometry/topology.h"
#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics {

// Unit normal at a place of the triangle, smooth over facets that meet at less than 35 degrees (kSmoothCosine), and at
// most 35 degrees off the facet's own. Flat faces give FaceNormal bit by bit. `weights`: barycentric, sum 1. The zero
// vector for a triangle without area.
template <MeshView View>
Vec3 ShadedNormal(const View& view, std::uint32_t triangle, const std::array<double, 3>& weights) noexcept;

// `direction` (unit, from the surface to the tip's proxy or back, on either side of the triangle) as shaded for a
// contact at `at` on the triangle: the shaded normal on its side. At sharp edges, borders and on flat faces it stays as
// it is, bit by bit.
template <MeshView View>
Vec3 ShadedDirection(const View& view, std::uint32_t triangle, const ClosestPoint& at, const Vec3& direction) noexcept;

extern template Vec3 ShadedNormal(const Surface&, std::uint32_t, const std::array<double, 3>&) noexcept;
extern template Vec3 ShadedDirection(const Surface&, std::uint32_t, const ClosestPoint&, const Vec3&) noexcept;
extern template Vec3 ShadedDirection(const sculpt::SculptSurface&, std::uint32_t, const ClosestPoint&,
                                     const Vec3&) noexcept;

}  // namespace omni::haptics
