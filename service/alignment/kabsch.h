// Point sets onto each other in closed form: the start of every fit, and the textbook answer that tests compare with.
#pragma once

#include <vector>

#include "service/alignment/types.h"

namespace omni::alignment {

struct PointPair {
  base::Vec3 base_m;   // p_B
  base::Vec3 space_m;  // p_L
  double weight = 1;   // > 0
};

// X_LB that minimises sum w |p_L - X_LB p_B|^2, a rotation in any case (never a reflection). Three pairs that are not
// on a line, at least: else the rotation is one of many.   [Kabsch 1976, Umeyama 1991; docs/theory/alignment.md (1)]
Rigid FitSixDof(const std::vector<PointPair>& pairs);

// The same with gravity known in both: B's z is L's y, only yaw and place are free. Two pairs that are not one above
// the other, at least.   [docs/theory/alignment.md (2)]
Rigid FitFourDof(const std::vector<PointPair>& pairs);

// A level base whose y points along L's -z.
Rigid LevelBase();

}  // namespace omni::alignment
