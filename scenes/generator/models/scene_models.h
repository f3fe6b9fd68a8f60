// The three scenes and the pen, as documents ready to be written. Pure functions: the same on every run.
#pragma once

#include "scenes/generator/mesh/glb_writer.h"

namespace omni::scenes {

Document ExtrusionScene();
Document DragonScene();
Document RacetrackScene();

// The pen as the render model of XR_EXT_interaction_render_model draws it. The document's frame is the tool frame T
// (docs/conventions.md): origin at the tip, -z out of it, y up; nodes have no transform of their own. Sizes are those
// of the pen drawing (docs/drawings/pen.svg): tests/scenes compares them with manifests/device.
struct PenShape {
  double magnet_radius_m = 0.015;
  double magnet_half_height_m = 0.0035;
  double tip_offset_m = 0.005;  // from the magnet's centre
  double flange_m = 0.003;      // as wide as the magnet
  double grip_diameter_m = 0.012;
  double grip_length_m = 0.100;
};

// The real pen feels through its coils and has no switch: `button` shows where and when a finger's tap counts.
Document PenModel(const PenShape& shape = {});

}  // namespace omni::scenes
