// One ball on a soft body: how deep it goes for a force, and the force of a ball alone. Its own dent, the displacement
// of the whole body and a spring, in series. Runs in the tick. docs/theory/deformable.md, section 6.
#pragma once

#include "service/haptics/deformable/local_model.h"

namespace omni::haptics {

struct BallCompliance {
  LocalModel model;
  double compliance_m_N = 0;  // of the body here, without the dent; may be negative
  double series_m_N = 0;      // of the spring, >= 0
  double limit_N = 1e300;     // for compliance < 0: from here on only a share of the dent is left   (6.4)
  double limit_dent_m = 1e300;
};

BallCompliance MakeBallCompliance(const LocalModel& model, double compliance_m_N, double series_m_N) noexcept;

struct GivePoint {
  double dent_m = 0;
  double depth_m = 0;    // h(f)
  double slope_m_N = 0;  // h'(f); infinite at no force, there that of a small one
};

// h(f) for a force >= 0. `near_m`: a dent near the answer's, 0: none known.
GivePoint GiveAtForce(const BallCompliance& give, double force_N, double near_m) noexcept;

// The force of one ball alone: h(f) = depth, to rounding. 0 for depths <= 0. `near_m` as above.
double ForceAlone(const BallCompliance& give, double depth_m, double near_m) noexcept;

}  // namespace omni::haptics
