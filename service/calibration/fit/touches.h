// Picks the touches out of "touch the hull in 100 places": the pen rests, then goes elsewhere.
#pragma once

#include <optional>

#include "service/calibration/fit/window.h"

namespace omni::calibration {

struct TouchOptions {
  int windows_min = 3;           // at rest in a row: 72 ms
  double apart_relative = 0.02;  // change of the field that makes it another place (a few mm)
};

class TouchPicker {
 public:
  explicit TouchPicker(const TouchOptions& options = {}) : options_(options) {}

  // Every window in turn; a touch when the pen has rested long enough at a new place.
  std::optional<Sample> Add(const WindowResult& window);
  // The pen moved faster than a window can follow.
  void AddJerk() { resting_ = 0; }

 private:
  TouchOptions options_;
  int resting_ = 0;
  std::vector<base::Vec3> last_sensor_T_;  // where the last touch was; empty: none yet
};

}  // namespace omni::calibration
