// A relief: heights on a surface, felt as a ripple of the normal force while the tip slides over them.
// docs/theory/haptics.md, (6.6).
#pragma once

#include <cstdint>

#include "service/base/vec.h"
#include "service/haptics/geometry/surface.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// Height of the relief over the surface, m, at a place in the rest frame near the plane of the triangle. Bands that a
// tip at this speed would meet too fast to follow, and those finer than its place is known, are left out. 0 where the
// triangle has no coordinates, or no area in them. Precondition: `relief` is below reliefs().size().
double ReliefHeight(const Scene& scene, std::uint32_t relief, const Surface& surface, std::uint32_t triangle,
                    const base::Vec3& place_m, double speed_m_s) noexcept;

// Force along the normal for this height above (out) or below (in) the surface.
double ReliefForce(double height_m, double gain, double stiffness_N_m, double normal_force_N) noexcept;

}  // namespace omni::haptics
