// A hand path that touches any scene: found by looking down on it, for the twin and for demos of unknown files.
#pragma once

#include "service/base/result.h"
#include "service/haptics/scene.h"
#include "service/sim/twin.h"

namespace omni::tools {

struct HandPathOptions {
  double hull_radius_m = 0.0375;
  double gap_min_m = 0.004;  // surface points this far above the hull ...
  double gap_max_m = 0.032;  // ... to this can be felt
  double reach_m = 0.025;    // from the z axis
  double press_m = 0.005;    // how far below the surface the hand aims
  int touches = 5;
};

// Approaches, presses, slides to the next point. Error when nothing of the scene lies within reach (says what does).
base::Result<sim::HandScript> MakeHandPath(const haptics::Scene& scene, const HandPathOptions& options);

// The JSON text that sim::LoadHandScript reads.
std::string WriteHandScript(const sim::HandScript& script);

}  // namespace omni::tools
