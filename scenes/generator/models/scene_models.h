// The three scenes, as documents ready to be written. Pure functions: the same on every run.
#pragma once

#include "scenes/generator/mesh/glb_writer.h"

namespace omni::scenes {

Document ExtrusionScene();
Document DragonScene();
Document RacetrackScene();

}  // namespace omni::scenes
