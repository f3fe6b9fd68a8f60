// The iron core responds to a dipole outside it like an image inside it. Core: sphere of radius a about the origin of
// B, permeability through kappa = (mu_r - 1) / (mu_r + 2); exact for kappa = 1, and to first order in 1 - kappa else.
// Valid for |p| > a and |x| > a.
#pragma once

#include <Eigen/Core>

namespace omni::magnetics {

// Image dipole and image charge at one place, and the opposite charge at the core's centre (the core is neutral).
struct CoreImage {
  Eigen::Vector3d position;
  Eigen::Vector3d moment;
  double charge = 0;
};

// docs/theory/magnetics.md (10)
CoreImage ImageInCore(const Eigen::Vector3d& m, const Eigen::Vector3d& p, double core_radius_m, double kappa) noexcept;

// Field of the image at x, and its derivative with respect to x while the image stays. docs/theory/magnetics.md (11)
Eigen::Vector3d CoreImageField(const CoreImage& image, const Eigen::Vector3d& x) noexcept;
Eigen::Matrix3d CoreImageGradient(const CoreImage& image, const Eigen::Vector3d& x) noexcept;

}  // namespace omni::magnetics
