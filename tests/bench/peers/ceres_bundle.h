// The bundle adjustment of self-calibration as Ceres solves it (DENSE_SCHUR, samples eliminated first): the same
// residuals, derivatives, priors and fixed weights as calibration::AdjustOnce. Without current maps of the coils.
#pragma once

#include <vector>

#include "service/calibration/fit/system.h"

namespace omni::peers {

struct BundleOptions {
  int iterations_max = 100;
  double function_tolerance = 1e-8;  // relative change of the cost
};

struct BundleFit {
  calibration::Parameters parameters;
  std::vector<calibration::Instant> instants;
  double cost = 0;  // as calibration::System counts it
  int iterations = 0;
  bool converged = false;
};

// Precondition: `problem` has no coils; one instant per observation.
BundleFit SolveBundle(const calibration::Problem& problem, const calibration::Parameters& start,
                      const std::vector<calibration::Instant>& instants, const BundleOptions& options);

}  // namespace omni::peers
