#include "service/protocol/surfaces/surface_range.h"

#include <algorithm>
#include <cmath>

namespace omni::protocol {
namespace {

constexpr std::uint64_t kMaxChange = std::uint64_t{1} << 62;

}  // namespace

// Without early exits, so that compilers vectorise it.
bool InRange(std::span<const SurfacePoint> vertices_base_m) noexcept {
  bool good = true;
  for (const SurfacePoint& p : vertices_base_m) {
    for (const float x : p) good &= std::abs(x) <= kMaxSurfaceCoordinate_m;
  }
  return good;
}

bool InRange(std::span<const SurfaceTriangle> triangles, std::uint32_t vertex_count) noexcept {
  bool good = true;
  for (const SurfaceTriangle& t : triangles) {
    for (const std::uint32_t vertex : t) good &= vertex < vertex_count;
  }
  return good;
}

bool InRange(const SurfaceFrame& frame) noexcept {
  double squared = 0;
  for (const double q : frame.rotation_wxyz) squared += q * q;
  bool good = std::abs(squared - 1) <= 1e-2;
  for (const double x : frame.translation_m) good &= std::abs(x) <= double{kMaxSurfaceCoordinate_m};
  good &= frame.largest_displacement_m >= 0 && frame.largest_displacement_m <= 2 * double{kMaxSurfaceCoordinate_m};
  return good && frame.vertex_change <= kMaxChange && frame.triangle_change <= kMaxChange;
}

}  // namespace omni::protocol
