// A person at the pen: what they perceive of a running omnid, and what they would do about a scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/client/connection.h"
#include "service/client/surface_reader.h"
#include "service/haptics/scene/scene.h"
#include "service/tools/hand/hand_task.h"
#include "service/tools/hand/touch_places.h"

namespace omni::tools {

// A person's perception of a running omnid: a client that requests what an application would draw.

// What to observe besides pen and car.
struct LookFor {
  bool soft = false;  // soft bodies
  bool clay = false;  // strokes
};

class Eyes {
 public:
  Eyes(const std::string& socket_path, const LookFor& look_for);

  Perceived Observe(std::int64_t now_ns);

  bool connected() const noexcept { return connection_.connected(); }
  const std::string& problem() const noexcept { return connection_.last_error(); }

 private:
  void SeePen(std::int64_t now_ns);
  void SeeSoftBodies();
  void AskForStrokes(std::int64_t now_ns);

  client::Connection connection_;
  const LookFor look_for_;
  Perceived seen_;
  std::shared_ptr<const client::SurfaceReader> surfaces_;
  std::vector<client::SurfaceCopy> copies_;  // of its objects
  std::uint32_t asked_ = 0;                  // number of the pending request for strokes; 0: none
  std::int64_t asked_ns_ = 0;
};

// What a person would do on seeing a scene for the first time: drive its car, or touch it.
struct Intent {
  std::unique_ptr<HandTask> task;
  bool soft = false, clay = false;  // what to observe besides the pen
};

// Error: why there is nothing to do.
base::Result<Intent> IntentFor(const haptics::Scene& scene, const PlaceOptions& options);

}  // namespace omni::tools
