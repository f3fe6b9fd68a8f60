// A hand path that touches any scene, found from its height map; for the twin and for demos of unknown files.
#pragma once

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/sim/twin/twin.h"
#include "service/tools/hand/touch_places.h"

namespace omni::tools {

struct HandPathOptions {
  PlaceOptions places;
  double press_m = 0.005;  // how far below the surface the hand aims
};

// Approaches, presses, slides to the next point. Error if nothing of the scene is within reach; it states the reach.
base::Result<sim::HandScript> MakeHandPath(const haptics::Scene& scene, const HandPathOptions& options);

// The JSON text that sim::LoadHandScript reads.
std::string WriteHandScript(const sim::HandScript& script);

}  // namespace omni::tools
