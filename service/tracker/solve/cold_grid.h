// The places that a cold start searches, and the readings that the magnet would cause at each. Set-up only.
// docs/theory/tracking.md (6.2), (6.3)
#pragma once

#include <vector>

#include "service/base/calibration.h"
#include "service/base/vec.h"
#include "service/tracker/kernel/kernel.h"

namespace omni::tracker {

struct ColdGrid {
  int places = 0;
  std::vector<base::Vec3> place_base_m;
  // Field per moment (T / A m^2): [group of kGridLanes places][reading 3 i + axis][moment axis in B][place].
  std::vector<float> field_sensor;
};

// Shells around the hull where there is one; else the calibration's volume, or the sensors' surroundings, cut into
// cells that are small against their distance from the nearest sensor.
ColdGrid MakeColdGrid(const base::Calibration& calibration);

}  // namespace omni::tracker
