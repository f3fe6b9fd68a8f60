#include "service/haptics/contact/texture.h"

#include <algorithm>
#include <cmath>

namespace omni::haptics {
namespace {

constexpr double kMaxRepeats = 1e9;  // beyond, a double has no fraction of a texel left

// Texel of a row of `size` that index i, which may lie outside, stands for   [glTF 2.0, 3.8.4.4]
std::uint32_t Wrapped(std::int64_t i, std::uint32_t size, std::uint32_t wrap) noexcept {
  const auto n = static_cast<std::int64_t>(size);
  if (wrap == static_cast<std::uint32_t>(Wrap::kClamp))
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(i, 0, n - 1));
  const std::int64_t period = wrap == static_cast<std::uint32_t>(Wrap::kMirror) ? 2 * n : n;
  const std::int64_t in_period = ((i % period) + period) % period;
  return static_cast<std::uint32_t>(in_period < n ? in_period : period - 1 - in_period);
}

}  // namespace

// Texel centres lie at (i + 1/2) / width: x = u' width - 1/2, between floor(x) and floor(x) + 1   (T.1), (T.2)
float SampleTexture(const Scene& scene, std::int32_t index, std::uint32_t triangle,
                    const std::array<double, 3>& weights) noexcept {
  if (index < 0) return 1;
  const Texture& texture = scene.textures()[static_cast<std::size_t>(index)];
  const Object& object = scene.objects()[scene.triangles()[triangle].object];
  const std::uint32_t first = object.first_uv[texture.uv_set];
  if (first == kNoIndex) return 1;
  const CornerUv& corners = scene.uvs()[first + (triangle - object.first_triangle)];
  double u = 0, v = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    u += weights[k] * static_cast<double>(corners[2 * k]);
    v += weights[k] * static_cast<double>(corners[2 * k + 1]);
  }
  const double* t = texture.to_image;
  const double x = (t[0] * u + t[1] * v + t[2]) * texture.width - 0.5;
  const double y = (t[3] * u + t[4] * v + t[5]) * texture.height - 0.5;
  if (!(std::abs(x) <= kMaxRepeats && std::abs(y) <= kMaxRepeats)) return 1;
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto texel = [&](double i, double j) noexcept {
    const std::uint32_t column = Wrapped(static_cast<std::int64_t>(i), texture.width, texture.wrap_u);
    const std::uint32_t row = Wrapped(static_cast<std::int64_t>(j), texture.height, texture.wrap_v);
    return static_cast<double>(scene.texels()[texture.first_texel + std::size_t{row} * texture.width + column]);
  };
  const double fx = x - x0, fy = y - y0;
  const double upper = (1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0);
  const double lower = (1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1);
  return static_cast<float>(((1 - fy) * upper + fy * lower) / 255);
}

}  // namespace omni::haptics
