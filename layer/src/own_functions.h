// The functions of our own extensions (layer/include), of all of them.
#pragma once

#include <vector>

#include "layer/src/dispatch.h"

namespace omni::layer {

const std::vector<OwnFunction>& OwnFunctions();

const std::vector<OwnFunction>& ForceFeedbackFunctions();  // entry_force_feedback.cc
const std::vector<OwnFunction>& HapticSceneFunctions();    // entry_haptic_scene.cc

}  // namespace omni::layer
