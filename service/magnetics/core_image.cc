#include "service/magnetics/core_image.h"

#include <cmath>

#include "service/magnetics/dipole.h"

namespace omni::magnetics {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A charge q at p has the image -q a/|p| at a^2/|p|^2 p and + q a/|p| at the centre; a dipole is two charges. With
// n = p/|p|:  m' = (a/|p|)^3 (2 (m.n) n - m),  q' = a (m.n) / |p|^2,  both at x' = (a/|p|)^2 p, and -q' at the centre.
// [Jackson 3e, 2.2, differentiated along m]
CoreImage ImageInCore(const Vector3d& m, const Vector3d& p, double core_radius_m, double kappa) noexcept {
  const double r = p.norm();
  const Vector3d n = p / r;
  const double ratio = core_radius_m / r;
  const double mn = m.dot(n);
  return {.position = ratio * ratio * p,
          .moment = kappa * ratio * ratio * ratio * (2 * mn * n - m),
          .charge = kappa * core_radius_m * mn / (r * r)};
}

Vector3d CoreImageField(const CoreImage& image, const Vector3d& x) noexcept {
  const Vector3d d = x - image.position;
  return DipoleField(image.moment, d) + ChargeField(image.charge, d) - ChargeField(image.charge, x);
}

Matrix3d CoreImageGradient(const CoreImage& image, const Vector3d& x) noexcept {
  const Vector3d d = x - image.position;
  return DipoleGradient(image.moment, d) + ChargeGradient(image.charge, d) - ChargeGradient(image.charge, x);
}

}  // namespace omni::magnetics
