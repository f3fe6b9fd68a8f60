// The value of a haptic texture at a place of the surface: what a material's factor is multiplied with.
// docs/theory/haptics.md, "Textures".
#pragma once

#include <array>
#include <cstdint>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// In [0, 1], bilinear, at barycentric `weights` of `triangle`. 1 if `texture` is -1, or where the triangle's object has
// no coordinates for it, or they are not finite. Precondition: `texture` is -1 or below textures().size(), `triangle`
// below triangles().size().
float SampleTexture(const Scene& scene, std::int32_t texture, std::uint32_t triangle,
                    const std::array<double, 3>& weights) noexcept;

}  // namespace omni::haptics
