// Extruding: press a face until it clicks, then pull it out or push it in by whole steps. docs/theory/haptics.md,
// section 9.
#pragma once

#include <span>

#include "service/haptics/geometry/surface.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// The tip's contact with one region in this tick; force 0: not touched.
struct RegionTouch {
  double normal_force_N = 0;
  double depth_m = 0;
};

struct ExtrudeInput {
  bool tracked = false;
  Vec3 tip;
  Vec3 velocity_m_s;
  double dt_s = 0;
  double stiffness_limit_N_m = 0;  // what stability allows
};

// Advances one region and returns the force it adds on the tool: the click, and the face sticking to the pen when
// pulled.
Vec3 StepRegion(const Region& region, const Extrude& extrude, const RegionTouch& touch, const ExtrudeInput& input,
                RegionState& state) noexcept;

}  // namespace omni::haptics
