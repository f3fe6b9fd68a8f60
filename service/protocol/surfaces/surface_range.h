// The range of what a surface memory may say. The writer publishes nothing else, the reader accepts nothing else.
#pragma once

#include <span>

#include "service/protocol/surfaces/surface_memory.h"

namespace omni::protocol {

// Every coordinate a number within +-kMaxSurfaceCoordinate_m.
bool InRange(std::span<const SurfacePoint> vertices_base_m) noexcept;
// Every corner below `vertex_count`.
bool InRange(std::span<const SurfaceTriangle> triangles, std::uint32_t vertex_count) noexcept;
// A rotation (|q|^2 within 1e-2 of 1), a translation within +-kMaxSurfaceCoordinate_m, a displacement >= 0, and
// publications that no writer exceeds. Counts are the caller's to check against its capacities.
bool InRange(const SurfaceFrame& frame) noexcept;

}  // namespace omni::protocol
