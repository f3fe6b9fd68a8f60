// What a stroke does; shared by the editor and the tick.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"

namespace omni::haptics::sculpt {

using base::Vec3;

// Share of the offset over the distance s = geodesic distance / radius.   (3.1)
enum class Falloff : std::uint8_t {
  kConstant = 0,  // 1, and a smooth rim over the outer fifth
  kLinear = 1,    // 1 - s
  kSmooth = 2,    // 1 - 3 s^2 + 2 s^3
};

inline double FalloffShare(Falloff falloff, double s) noexcept {
  constexpr double kRim = 0.2;
  if (!(s < 1)) return 0;
  if (falloff == Falloff::kLinear) return 1 - s;
  const double x = falloff == Falloff::kConstant ? std::max(0.0, (s - (1 - kRim)) / kRim) : s;
  return 1 - x * x * (3 - 2 * x);
}

struct SymmetryPlane {
  bool enabled = false;
  Vec3 point_base_m;
  Vec3 normal{1, 0, 0};  // any length but 0
};

struct Brush {
  double radius_m = 0.005;  // (0, 1], along the surface
  Falloff falloff = Falloff::kSmooth;
  SymmetryPlane symmetry;
};
static_assert(std::is_trivially_copyable_v<Brush>);

}  // namespace omni::haptics::sculpt
