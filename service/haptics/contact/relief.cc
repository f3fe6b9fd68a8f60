#include "service/haptics/contact/relief.h"

#include <algorithm>
#include <cmath>

#include "service/haptics/contact/effects.h"
#include "service/haptics/contact/grating.h"

namespace omni::haptics {
namespace {

constexpr double kFinest_m = 2.5e-4;  // width of a texel: full above, nothing below a half
constexpr double kMostRelief_N = 0.2;

// Where a place is in the image, and how large the image is there.
struct ImagePlace {
  bool known = false;
  double u = 0, v = 0;
  double side_m = 0;  // root of the area that the whole image takes
};

// x = p0 + b e1 + c e2 in the triangle's plane, also beyond its edges; coordinates are linear in b and c.
ImagePlace PlaceInImage(const Scene& scene, const Texture& texture, const Surface& surface, std::uint32_t triangle,
                        const Vec3& x) noexcept {
  const Object& object = scene.objects()[scene.triangles()[triangle].object];
  const std::uint32_t first = object.first_uv[texture.uv_set];
  if (first == kNoIndex) return {};
  const CornerUv& uv = scene.uvs()[first + (triangle - object.first_triangle)];
  const Corners p = surface.TriangleCorners(triangle);
  const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0], d = x - p[0];
  const double g11 = Dot(e1, e1), g12 = Dot(e1, e2), g22 = Dot(e2, e2), g = g11 * g22 - g12 * g12;
  if (!(g > 0)) return {};
  const double b = (g22 * Dot(d, e1) - g12 * Dot(d, e2)) / g, c = (g11 * Dot(d, e2) - g12 * Dot(d, e1)) / g;
  const double u1 = double{uv[2]} - uv[0], v1 = double{uv[3]} - uv[1], u2 = double{uv[4]} - uv[0],
               v2 = double{uv[5]} - uv[1];
  const double u = uv[0] + b * u1 + c * u2, v = uv[1] + b * v1 + c * v2;
  const double* t = texture.to_image;
  const double area = std::abs((u1 * v2 - v1 * u2) * (t[0] * t[4] - t[1] * t[3]));
  if (!(area > 0)) return {};
  return {true, t[0] * u + t[1] * v + t[2], t[3] * u + t[4] * v + t[5], std::sqrt(std::sqrt(g) / area)};
}

double RampUp(double x, double from, double to) noexcept { return std::clamp((x - from) / (to - from), 0.0, 1.0); }

}  // namespace

// h = s sum_k w_k step_k (t_k(u, v) - 128), s: width of a texel of the image, t_k: texel of band k   (6.6)
double ReliefHeight(const Scene& scene, std::uint32_t index, const Surface& surface, std::uint32_t triangle,
                    const Vec3& place_m, double speed_m_s) noexcept {
  const Relief& relief = scene.reliefs()[index];
  const ImagePlace at = PlaceInImage(scene, relief.finest, surface, triangle, place_m);
  if (!at.known) return 0;
  double sum = 0;
  Texture band = relief.finest;
  for (std::uint32_t k = 0; k < relief.bands; ++k) {
    const double texels = static_cast<double>(band.width) * static_cast<double>(band.height);
    const double texel_m = at.side_m / std::sqrt(texels);
    const double weight = RampUp(texel_m, 0.5 * kFinest_m, kFinest_m) *
                          RampUp(-speed_m_s / (2 * texel_m), -kRippleStop_Hz, -kRippleFade_Hz);
    if (weight > 0) sum += weight * double{relief.step[k]} * (SampleTexels(scene, band, at.u, at.v) - 128);
    band.first_texel += band.width * band.height;
    band.width = std::max(band.width / 2, 1U);
    band.height = std::max(band.height / 2, 1U);
  }
  const double image_texels = static_cast<double>(relief.image_width) * static_cast<double>(relief.image_height);
  const double height_m = at.side_m / std::sqrt(image_texels) * sum;
  return std::isfinite(height_m) ? height_m : 0;
}

// F = g K h, at most 0.2 N and half the normal force   (6.6)
double ReliefForce(double height_m, double gain, double stiffness_N_m, double normal_force_N) noexcept {
  const double most_N = std::max(0.0, std::min(kMostRelief_N, 0.5 * normal_force_N));
  return std::clamp(gain * stiffness_N_m * height_m, -most_N, most_N);
}

}  // namespace omni::haptics
