// A touch, in a stream of poses: the tip came, stays, and is taken away. No key needs to be pressed.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "service/alignment/types.h"

namespace omni::alignment {

struct DwellOptions {
  double still_s = 0.5;     // so long within ...
  double still_m = 3.0e-3;  // ... this of its mean: a touch
  double apart_m = 0.03;    // the next one is at least so far from the last
};

class DwellDetector {
 public:
  explicit DwellDetector(DwellOptions options = {}) : options_(options) {}

  // The tip's place at that time, in any one frame. A result: the touch is complete, its mean place.
  std::optional<base::Vec3> Add(double t_s, const base::Vec3& tip_m);
  // A touch was taken here by other means: the next one is elsewhere.
  void Settle(const base::Vec3& tip_m);
  // A hand's tracking was lost, or the person starts over.
  void Reset();
  // 0 to 1: how much of the time the tip has been still for.
  double progress() const { return progress_; }

 private:
  struct Seen {
    double t_s;
    base::Vec3 tip_m;
  };
  DwellOptions options_;
  std::deque<Seen> window_;
  std::optional<base::Vec3> last_;  // the touch before
  double progress_ = 0;
};

// The mean of poses that are close to each other.
Rigid MeanPose(const std::vector<Rigid>& poses);

}  // namespace omni::alignment
