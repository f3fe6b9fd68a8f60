#include "service/sim/fields/steel.h"

#include <cmath>
#include <numbers>

#include "service/sim/fields/vec3.h"

namespace omni::sim {
namespace {

// Gauss-Legendre nodes and weights on [-1, 1] [Abramowitz, Stegun 25.4].
constexpr std::array<double, 9> kPlace{
    -0.9681602395076261, -0.8360311073266358, -0.6133714327005904, -0.3242534234038089, 0,
    0.3242534234038089,  0.6133714327005904,  0.8360311073266358,  0.9681602395076261};
constexpr std::array<double, 9> kWeight{0.0812743883615744, 0.1806481606948574, 0.2606106964029354,
                                        0.3123470770400029, 0.3302393550012598, 0.3123470770400029,
                                        0.2606106964029354, 0.1806481606948574, 0.0812743883615744};

// Demagnetising factor of a slender ellipsoid of revolution along its axis, e^2 = 1 - 1/m^2, m the ratio of its axes:
// N = (1 - e^2) / e^2 (atanh(e) / e - 1)   [Osborn 1945, (11)]; 1/3 of a ball.
double DemagnetisingFactor(double ratio) noexcept {
  if (!(ratio > 1)) return 1.0 / 3;
  const double e2 = 1 - 1 / (ratio * ratio);
  const double e = std::sqrt(e2);
  return (1 - e2) / e2 * (std::atanh(e) / e - 1);
}

}  // namespace

Vec3 DipoleField(const Vec3& moment_Am2, const Vec3& point_m) noexcept {
  const double r = Norm(point_m);
  const Vec3 n = (1 / r) * point_m;
  return (kMu0Over4Pi / (r * r * r)) * (3 * Dot(moment_Am2, n) * n - moment_Am2);
}

// Infinite permeability: m = V B / (mu0 N). The moment's density over the axis is that of the cross-section, 1 - t^2.
SteelPiece::SteelPiece(const base::Steel& steel) noexcept : steel_(steel) {
  if (steel.shape == base::SteelShape::kPlane) return;
  const bool bar = steel.shape == base::SteelShape::kBar && steel.half_length_m > steel.radius_m;
  const double half_length_m = bar ? steel.half_length_m : steel.radius_m;
  const double volume_m3 = 4.0 / 3 * std::numbers::pi * steel.radius_m * steel.radius_m * half_length_m;
  const double along = DemagnetisingFactor(half_length_m / steel.radius_m);
  along_Am2_T_ = steel.strength * volume_m3 / (kMu0 * along);
  across_Am2_T_ = steel.strength * volume_m3 / (kMu0 * 0.5 * (1 - along));
  node_count_ = bar ? kNodes : 1;
  share_[0] = 1;
  node_base_m_[0] = steel.position_base_m;
  for (std::size_t i = 0; bar && i < kNodes; ++i) {
    share_[i] = 0.75 * kWeight[i] * (1 - kPlace[i] * kPlace[i]);
    node_base_m_[i] = steel.position_base_m + (kPlace[i] * half_length_m) * steel.direction_base;
  }
}

Vec3 SteelPiece::MirroredDirection(const Vec3& v) const noexcept {
  return v - (2 * Dot(v, steel_.direction_base)) * steel_.direction_base;
}

Vec3 SteelPiece::MirroredPoint(const Vec3& point_base_m) const noexcept {
  return steel_.position_base_m + MirroredDirection(point_base_m - steel_.position_base_m);
}

Vec3 SteelPiece::AnswerTo(const Vec3& mean_T, const Vec3& point_base_m) const noexcept {
  const double along_T = Dot(mean_T, steel_.direction_base);
  const Vec3 moment_Am2 = across_Am2_T_ * mean_T + ((along_Am2_T_ - across_Am2_T_) * along_T) * steel_.direction_base;
  Vec3 field_T;
  for (std::size_t i = 0; i < node_count_; ++i) {
    field_T += DipoleField(share_[i] * moment_Am2, point_base_m - node_base_m_[i]);
  }
  return field_T;
}

}  // namespace omni::sim
