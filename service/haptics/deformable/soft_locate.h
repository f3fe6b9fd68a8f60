// Finds the place on the coarse surface that is nearest to a point, from a hint or from the seed grid. Runs in the
// tick.
#pragma once

#include "service/haptics/deformable/soft_body.h"

namespace omni::haptics {

// Local descent over the coarse triangles, at most 32 moves. `hint`: a triangle near by, or kNoSoftTriangle. A point
// that is not finite gives triangle 0.
SoftPlace LocateOnSoftBody(const SoftBodyView& body, const Vec3& point_base_m, std::uint32_t hint) noexcept;

}  // namespace omni::haptics
