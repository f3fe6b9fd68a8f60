// The iron core responds to a dipole outside it like an image inside it. Core: sphere of radius a about the origin of
// B, permeability through kappa = (mu_r - 1) / (mu_r + 2); exact for kappa = 1, and to first order in 1 - kappa else.
// Valid for |p| > a and |x| > a.
#pragma once

#include <Eigen/Core>

#include "service/magnetics/dipole.h"

namespace omni::support {

// Image dipole and image charge at one place, and the opposite charge at the core's centre (the core is neutral).
struct CoreImage {
  Eigen::Vector3d position;
  Eigen::Vector3d moment;
  double charge = 0;
};

// docs/theory/magnetics.md (10). A charge q at p has the image -q a/|p| at a^2/|p|^2 p and + q a/|p| at the centre; a
// dipole is two charges. With n = p/|p|:  m' = (a/|p|)^3 (2 (m.n) n - m),  q' = a (m.n) / |p|^2,  both at x' =
// (a/|p|)^2 p, and -q' at the centre. [Jackson 3e, 2.2, differentiated along m]
inline CoreImage ImageInCore(const Eigen::Vector3d& m, const Eigen::Vector3d& p, double core_radius_m,
                             double kappa) noexcept {
  const double r = p.norm();
  const Eigen::Vector3d n = p / r;
  const double ratio = core_radius_m / r;
  const double mn = m.dot(n);
  return {.position = ratio * ratio * p,
          .moment = kappa * ratio * ratio * ratio * (2 * mn * n - m),
          .charge = kappa * core_radius_m * mn / (r * r)};
}

// Field of the image at x, and its derivative with respect to x while the image stays. docs/theory/magnetics.md (11)
inline Eigen::Vector3d CoreImageField(const CoreImage& image, const Eigen::Vector3d& x) noexcept {
  const Eigen::Vector3d d = x - image.position;
  return magnetics::DipoleField(image.moment, d) + magnetics::ChargeField(image.charge, d) -
         magnetics::ChargeField(image.charge, x);
}

inline Eigen::Matrix3d CoreImageGradient(const CoreImage& image, const Eigen::Vector3d& x) noexcept {
  const Eigen::Vector3d d = x - image.position;
  return magnetics::DipoleGradient(image.moment, d) + magnetics::ChargeGradient(image.charge, d) -
         magnetics::ChargeGradient(image.charge, x);
}

}  // namespace omni::support
