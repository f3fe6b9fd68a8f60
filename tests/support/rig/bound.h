// The Cramer-Rao bound of one static scan: no unbiased estimate can beat it, whatever its method. Derivatives are
// central differences of the truth itself, never of a tracker's model. docs/theory/truth.md (12)-(14).
#pragma once

#include <array>
#include <limits>
#include <optional>

#include "tests/support/rig/rig.h"

namespace omni::sim {

// Unknowns besides the pose. rms of the priors: 0: known, infinite: no prior.
struct BoundOptions {
  static constexpr double kUnknown = std::numeric_limits<double>::infinity();
  std::array<double, 3> noise_T{};  // rms per axis; all > 0
  double current_prior_A = 0;       // of each coil's current
  double ambient_prior_T = 0;       // of each component of a uniform field
  double moment_prior = 0;          // of the magnet's moment, relative
  CoilArray current_A{};            // flowing: moves axes towards saturation
  bool saturation = true;           // axes beyond the range are not used
};

// Covariance of (position 3, turn of the axis 2): u' = normalise(u + a tangent[0] + b tangent[1]).
struct PoseBound {
  std::array<Vec3, 2> tangent_base;
  std::array<double, 25> covariance{};  // row-major, (m, rad)
  double position_m2 = 0;               // trace of the position block: least possible mean of |e|^2
  double orientation_rad2 = 0;          // trace of the other block
};

// Empty: the readings do not determine the pose.
std::optional<PoseBound> CramerRao(Rig& rig, const MagnetPose& pose, const BoundOptions& options);

}  // namespace omni::sim
