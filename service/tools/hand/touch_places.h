// Where a scene can be touched from above, found from its height map.
#pragma once

#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"
#include "service/sim/twin/twin.h"

namespace omni::tools {

struct PlaceOptions {
  double hull_radius_m = 0.0375;
  double gap_min_m = 0.004;     // surface points this far above the hull ...
  double gap_max_m = 0.032;     // ... to this are within reach; ...
  double gap_strong_m = 0.010;  // ... if there are any up to here, where the base is strong, only those
  double reach_m = 0.025;       // from the z axis
  int places = 5;               // at most
};

struct TouchPlace {
  base::Vec3 point_base_m;     // on the surface
  std::uint32_t material = 0;  // of the scene
};

// Spread out, those on which a pressed pen holds best; the first one is nearest to the z axis. None: nothing of the
// scene lies within reach.
std::vector<TouchPlace> FindTouchPlaces(const haptics::Scene& scene, const PlaceOptions& options);

// Error text for when FindTouchPlaces finds nothing.
std::string NothingWithinReach(const PlaceOptions& options);

// A hand path that touches any scene, found from its height map; for the twin and for demos of unknown files.
struct HandPathOptions {
  PlaceOptions places;
  double press_m = 0.005;  // how far below the surface the hand aims
};

// Approaches, presses, slides to the next point. Error if nothing of the scene is within reach; it states the reach.
base::Result<sim::HandScript> MakeHandPath(const haptics::Scene& scene, const HandPathOptions& options);

// The JSON text that sim::LoadHandScript reads.
std::string WriteHandScript(const sim::HandScript& script);

}  // namespace omni::tools
