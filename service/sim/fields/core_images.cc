#include "service/sim/fields/core_images.h"

#include <cmath>

namespace omni::sim {
namespace {

// Gauss-Legendre nodes on [0, 1]: where three points represent a line best.
constexpr std::array<double, 3> kNodePlaces{0.11270166537925831, 0.5, 0.88729833462074169};

// Weights w with sum w t^l = moments[l - 1], l = 1, 2, 3: v = w t by the Lagrange polynomials of the nodes.
std::array<double, 3> MatchMoments(const std::array<double, 3>& moments) noexcept {
  std::array<double, 3> weights{};
  for (std::size_t j = 0; j < 3; ++j) {
    const double t = kNodePlaces[j];
    const double a = kNodePlaces[(j + 1) % 3];
    const double b = kNodePlaces[(j + 2) % 3];
    const double v = (moments[2] - (a + b) * moments[1] + a * b * moments[0]) / ((t - a) * (t - b));
    weights[j] = v / t;
  }
  return weights;
}

}  // namespace

CoreImages::CoreImages(double core_radius_m, double core_kappa, const Vec3& centre_base_m) noexcept
    : radius_m_(core_radius_m), centre_base_m_(centre_base_m), image_strength_(1) {
  if (!(core_kappa < 1)) return;
  const double mu = (1 + 2 * core_kappa) / (1 - core_kappa);
  image_strength_ = (mu - 1) / (mu + 1);
  node_count_ = kNodes;
  std::array<double, kNodes> moments{};
  for (std::size_t l = 1; l <= kNodes; ++l) moments[l - 1] = -1 / (static_cast<double>(l) * (mu + 1) + 1);
  weight_ = MatchMoments(moments);
}

void CoreImages::PlaceImages(const Charges& charges, Charges& images) const noexcept {
  const std::size_t count = charges.size();
  double centre = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 from_centre = charges.position(i) - centre_base_m_;
    const double r2 = Dot(from_centre, from_centre);
    const double scale = radius_m_ * radius_m_ / r2;
    const double q = -image_strength_ * charges.q[i] * radius_m_ / std::sqrt(r2);
    const auto put = [&](std::size_t at, double t, double weight) {
      images.x[at] = centre_base_m_.x + t * scale * from_centre.x;
      images.y[at] = centre_base_m_.y + t * scale * from_centre.y;
      images.z[at] = centre_base_m_.z + t * scale * from_centre.z;
      images.q[at] = weight * q;
      centre -= weight * q;
    };
    put(i, 1, 1);
    for (std::size_t j = 0; j < node_count_; ++j) put((1 + j) * count + i, kNodePlaces[j], weight_[j]);
  }
  const std::size_t last = image_count(count) - 1;
  images.x[last] = centre_base_m_.x;
  images.y[last] = centre_base_m_.y;
  images.z[last] = centre_base_m_.z;
  images.q[last] = centre;
}

}  // namespace omni::sim
