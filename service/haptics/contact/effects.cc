#include "service/haptics/contact/effects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "service/haptics/deformable/local_model.h"
#include "service/haptics/sculpt/sculpt_surface.h"

namespace omni::haptics {
namespace {

double SinTurns(double turns) noexcept { return std::sin(2 * std::numbers::pi * turns); }

}  // namespace

// F = min(A, F_n) sin(2 pi f t)   (6.2): never lifts off.
double VibrationEffect::ForceOn(std::int64_t t_ns, double normal_force_N) const noexcept {
  if (!(amplitude_N > 0 && frequency_Hz > 0)) return 0;
  const double turns = std::fmod(1e-9 * static_cast<double>(t_ns) * frequency_Hz, 1.0);
  return std::min(amplitude_N, normal_force_N) * SinTurns(turns);
}

Vec3 ViscosityEffect::ForceOn(const Vec3& velocity_m_s) const noexcept {
  return -std::clamp(viscosity_Ns_m, 0.0, limit_Ns_m) * velocity_m_s;
}

// F = 4 F_max x (1 - x), x = gap / range; steepest slope 4 F_max / range stays within the stiffness limit   (6.3)
double MagnetEffect::ForceOn(double gap_m, double stiffness_limit_N_m) const noexcept {
  if (!(gap_m > 0 && gap_m < range_m)) return 0;
  const double peak_N = std::min(max_force_N, 0.25 * stiffness_limit_N_m * range_m);
  const double x = gap_m / range_m;
  return 4 * peak_N * x * (1 - x);
}

namespace {

// Half-space of the soft body's material under the ball, in series with K, which carries the relaxing part too: as a
// body that is ready, but for what its shape adds   (4.4); deformable.md (5.1), (7.2).
double HalfSpaceForce(const Softness& softness, double stiffness_N_m, double depth_m, double ball_m, double dt_s,
                      ContactState& contact) noexcept {
  if (!(stiffness_N_m > 0)) return 0;
  const double nu = std::clamp(softness.poisson_ratio, 0.0, 0.49);
  const double keep = softness.relaxation_time_s > 0 ? std::exp(-dt_s / softness.relaxation_time_s) : 0;
  const double gain = keep * kRelaxingShare, series_m_N = 1 / stiffness_N_m;
  const double rest_N = keep * (contact.relaxation_N - kRelaxingShare * contact.elastic_N);
  const LocalModel model{std::max(softness.young_modulus_Pa, 1.0) / (1 - nu * nu), ball_m,
                         GainOf(nu, softness.hardening)};
  const BallCompliance give = MakeBallCompliance(model, 0, series_m_N * (1 + gain));
  contact.elastic_N = ForceAlone(give, std::min(depth_m, kDeepest_balls * ball_m) - series_m_N * rest_N, 0);
  contact.relaxation_N = gain * contact.elastic_N + rest_N;
  return std::max(0.0, contact.elastic_N + contact.relaxation_N);
}

}  // namespace

// Sphere R on a Winkler layer of thickness h: F = pi R E_c delta^2 / h, E_c = E (1 - nu) / ((1 + nu)(1 - 2 nu))
// [Johnson, Contact Mechanics, 4.3]. In series with K: K (d - delta) = c delta^2, so
// delta = 2 K d / (K + sqrt(K^2 + 4 c K d)), at most max_depth; then only the spring K is left.   (4.1), (4.2)
double ElasticForce(const Softness& softness, double stiffness_N_m, double depth_m, double ball_m) noexcept {
  if (!(depth_m > 0 && stiffness_N_m > 0)) return 0;
  if (softness.model == SoftnessModel::kNone) return stiffness_N_m * depth_m;
  const double nu = std::clamp(softness.poisson_ratio, 0.0, 0.49);
  const double confined_Pa = softness.young_modulus_Pa * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  const double c = std::numbers::pi * ball_m * confined_Pa / std::max(softness.thickness_m, 1e-6);
  const double k = stiffness_N_m;
  const double delta = 2 * k * depth_m / (k + std::sqrt(k * k + 4 * std::max(c, 0.0) * k * depth_m));
  return k * (depth_m - std::min(delta, std::max(softness.max_depth_m, 0.0)));
}

// Maxwell branch beside the layer: r' = g F' - r / tau, exactly integrated over a tick   (4.3). The series stiffness is
// lowered by 1 + g, so that the instantaneous slope stays within the stiffness bound.
double LayerForce(const Softness& softness, double stiffness_N_m, double depth_m, double ball_m, double dt_s,
                  ContactState& contact) noexcept {
  if (softness.model == SoftnessModel::kNone) return ElasticForce(softness, stiffness_N_m, depth_m);
  if (softness.model == SoftnessModel::kTet)
    return HalfSpaceForce(softness, stiffness_N_m, depth_m, ball_m, dt_s, contact);
  const double elastic_N = ElasticForce(softness, stiffness_N_m / (1 + kRelaxingShare), depth_m, ball_m);
  const double keep = softness.relaxation_time_s > 0 ? std::exp(-dt_s / softness.relaxation_time_s) : 0;
  contact.relaxation_N = keep * (contact.relaxation_N + kRelaxingShare * (elastic_N - contact.elastic_N));
  contact.elastic_N = elastic_N;
  return std::max(0.0, elastic_N + contact.relaxation_N);
}

namespace {

void SetAnchor(std::uint32_t triangle, const ClosestPoint& at, ContactState& contact) noexcept {
  contact.anchor_triangle = triangle;
  contact.anchor_weights = at.weights;
}

// The anchor's displacement from the proxy, in the tangent plane.
template <MeshView View>
Vec3 StretchOf(const View& view, const FrictionInput& input, const ContactState& contact) noexcept {
  const Vec3 u = AnchorPosition(view, contact) - input.proxy;
  return u - Dot(u, input.normal) * input.normal;
}

}  // namespace

// Stick: F_t = k u, u = anchor - proxy, while |F_t| <= mu_s F_n. Slip: the anchor is dragged so that |F_t| = mu_d F_n;
// a tick in which it need not be dragged sticks again.   (5.1)-(5.3)
template <MeshView View>
Vec3 FrictionForce(const View& view, const FrictionInput& input, ContactState& contact) noexcept {
  if (!(input.static_friction > 0) || !(input.stiffness_N_m > 0)) {
    contact.anchor_triangle = kNoIndex;
    contact.sticking = false;
    return {};
  }
  if (contact.anchor_triangle == kNoIndex) {
    SetAnchor(input.proxy_triangle, ClosestOnTriangle(view.TriangleCorners(input.proxy_triangle), input.proxy),
              contact);
    contact.sticking = true;
  }
  const Vec3 u = StretchOf(view, input, contact);
  const double length_m = Norm(u);
  const double mu = contact.sticking ? input.static_friction : input.dynamic_friction;
  if (input.stiffness_N_m * length_m <= mu * input.normal_force_N) {
    contact.sticking = true;
    return input.stiffness_N_m * u;
  }
  contact.sticking = false;
  const double allowed_m = input.dynamic_friction * input.normal_force_N / input.stiffness_N_m;
  const Vec3 dragged = (allowed_m / length_m) * u;
  const ProxyPoint anchor = DescendOnSurface(view, input.proxy_triangle, input.proxy + dragged);
  SetAnchor(anchor.triangle, anchor.closest, contact);
  return input.stiffness_N_m * dragged;
}

template Vec3 FrictionForce(const Surface&, const FrictionInput&, ContactState&) noexcept;
template Vec3 FrictionForce(const sculpt::SculptSurface&, const FrictionInput&, ContactState&) noexcept;

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
  const double texel = SampleTexels(scene, texture, t[0] * u + t[1] * v + t[2], t[3] * u + t[4] * v + t[5]);
  return std::isfinite(texel) ? static_cast<float>(texel / 255) : 1;
}

// Texel centres lie at (i + 1/2) / width: x = u' width - 1/2, between floor(x) and floor(x) + 1   (T.1), (T.2)
double SampleTexels(const Scene& scene, const Texture& texture, double u, double v) noexcept {
  const double x = u * texture.width - 0.5, y = v * texture.height - 0.5;
  if (!(std::abs(x) <= kMaxRepeats && std::abs(y) <= kMaxRepeats)) return std::numeric_limits<double>::quiet_NaN();
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto texel = [&](double i, double j) noexcept {
    const std::uint32_t column = Wrapped(static_cast<std::int64_t>(i), texture.width, texture.wrap_u);
    const std::uint32_t row = Wrapped(static_cast<std::int64_t>(j), texture.height, texture.wrap_v);
    return static_cast<double>(scene.texels()[texture.first_texel + std::size_t{row} * texture.width + column]);
  };
  const double fx = x - x0, fy = y - y0;
  const double upper = (1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0);
  const double lower = (1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1);
  return (1 - fy) * upper + fy * lower;
}

}  // namespace omni::haptics
