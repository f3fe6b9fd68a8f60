// Where is the point of a controller that rests in a dimple? The controller is swung about it.
#pragma once

#include <vector>

#include "service/alignment/types.h"
#include "service/base/result.h"

namespace omni::alignment {

struct Pivot {
  base::Vec3 tip_controller_m;
  base::Vec3 centre_space_m;  // where it rested
  double rms_m = 0;
  double tip_sigma_m = 0;  // 1 sigma, norm over axes; counts correlated poses for what they are worth
};

inline constexpr int kPivotPoses_min = 20;
inline constexpr double kPivotRms_max_m = 5e-3;
inline constexpr double kPivotSigma_max_m = 3e-3;

// R_LC l + p_LC = c for all poses, linear in l and c. Refuses too few poses, too little turning, and a tip that moved;
// the error says what to do.   [docs/theory/alignment.md (4)]
base::Result<Pivot> SolvePivot(const std::vector<Rigid>& controller_space);

}  // namespace omni::alignment
