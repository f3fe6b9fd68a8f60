// What a hand does with a controller: it touches a place (dwell.cc), or swings about its point (pivot.cc).
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "service/alignment/types.h"
#include "service/base/result.h"

namespace omni::alignment {

struct DwellOptions {
  double still_s = 0.5;     // so long within ...
  double still_m = 3.0e-3;  // ... this of its mean: a touch
  double apart_m = 0.03;    // the next one is at least so far from the last
};

// A touch, in a stream of poses: the tip came, stays, and is taken away. No key needs to be pressed.
class DwellDetector {
 public:
  explicit DwellDetector(DwellOptions options = {}) : options_(options) {}

  // The tip's place at that time, in any one frame. A result: the touch is complete, its mean place.
  std::optional<base::Vec3> Add(double t_s, const base::Vec3& tip_m);
  // A touch was taken here by other means: the next one is elsewhere.
  void MarkTouched(const base::Vec3& tip_m);
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

// Where is the point of a controller that rests in a dimple? The controller is swung about it.
struct Pivot {
  base::Vec3 tip_controller_m;
  base::Vec3 centre_space_m;  // where it rested
  double rms_m = 0;
  double tip_sigma_m = 0;  // 1 sigma, norm over axes; counts correlated poses for what they are worth
};

inline constexpr int kPivotPoses_min = 20;
inline constexpr double kPivotRms_max_m = 5e-3;
inline constexpr double kPivotSigma_max_m = 3e-3;

// R_LC l + p_LC = c for all poses, linear in l and c. Refuses too few poses, too little turning, and a tip that moved;
// the error says what to do.   [docs/theory/alignment.md (4)]
base::Result<Pivot> SolvePivot(const std::vector<Rigid>& controller_space);

}  // namespace omni::alignment
