// What a person would do on seeing a scene for the first time: drive its car, or touch it.
#pragma once

#include <memory>

#include "service/base/result.h"
#include "service/haptics/scene/scene.h"
#include "service/tools/hand/hand_task.h"
#include "service/tools/hand/touch_places.h"

namespace omni::tools {

struct Intent {
  std::unique_ptr<HandTask> task;
  bool soft = false, clay = false;  // what to observe besides the pen
};

// Error: why there is nothing to do.
base::Result<Intent> IntentFor(const haptics::Scene& scene, const PlaceOptions& options);

}  // namespace omni::tools
