// Readings of a moving pen at one instant: a parabola through a short window of scans, each sensor at its own sample
// times, read off in the window's middle. Averages noise without smearing the motion. docs/theory/calibration.md (6.1)
#pragma once

#include <optional>
#include <vector>

#include "service/base/hall_scan.h"
#include "service/calibration/types.h"

namespace omni::calibration {

struct WindowOptions {
  int scans = 24;                // at 1 kHz: 24 ms
  double misfit_max = 2;         // mean square deviation from the parabola, in noise variances: more is a jerk
  double still_relative = 2e-3;  // change of the field from the middle to the end that counts as still ...
  double still_sigmas = 4;       // ... beside so many standard deviations of the noise in it
};

struct WindowResult {
  Sample sample;
  bool still = false;  // the pen rested
};

class Window {
 public:
  Window(const WindowOptions& options, const std::array<double, 3>& sensor_noise_T);

  // The window's result when it is full and smooth; then the next window starts.
  std::optional<WindowResult> Add(const base::HallScan& scan);

 private:
  std::optional<WindowResult> Fit() const;

  WindowOptions options_;
  std::array<double, 3> noise_T_;
  std::vector<base::HallScan> scans_;
};

// Picks the touches out of "touch the hull in 100 places": the pen rests, then goes elsewhere.
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
