// Bundle adjustment: Levenberg-Marquardt on array and samples together, the samples eliminated. Samples that do not fit
// lose weight. docs/theory/calibration.md (4.1) - (4.3), docs/decisions/0009
#pragma once

#include <Eigen/Core>
#include <vector>

#include "service/calibration/fit/system.h"

namespace omni::calibration {

struct Adjustment {
  Parameters parameters;
  std::vector<Instant> instants;
  System system;               // at the solution
  Eigen::MatrixXd covariance;  // of the array's unknowns; unit matrix: nothing but the tolerances
  int iterations = 0;          // linearisations
  bool converged = false;
};

// One round: least squares with the weights that the observations have. Without covariance.
Adjustment AdjustOnce(const Problem& problem, Parameters parameters, std::vector<Instant> instants, int iterations_max);

// Three standard deviations, and enough to matter. `adjustment`: with covariance.
bool SeesSteel(const Adjustment& adjustment);

// Rounds until the weights settle, the steel's depth free; with the depth held if no steel is seen so, and without
// steel if none is seen so either. `problem`: weights of its observations are changed.
Adjustment Adjust(Problem& problem, Parameters parameters, std::vector<Instant> instants, int iterations_max);

// H and g with the samples eliminated; damping multiplies the diagonals. (4.2)
struct Reduced {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
};
Reduced EliminateSamples(const System& system, double damping);

}  // namespace omni::calibration
