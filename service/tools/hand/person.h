// What a person would do with a scene who sees it for the first time: drive its car, or touch it.
#pragma once

#include <memory>

#include "service/base/result.h"
#include "service/haptics/scene.h"
#include "service/tools/hand/hand_task.h"
#include "service/tools/hand/touch_places.h"

namespace omni::tools {

struct Intent {
  std::unique_ptr<HandTask> task;
  bool soft = false, clay = false;  // what there is to look at besides the pen
};

// Error: there is nothing to do, and why.
base::Result<Intent> IntentFor(const haptics::Scene& scene, const PlaceOptions& options);

}  // namespace omni::tools
