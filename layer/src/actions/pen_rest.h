// Whether the pen is put down: then the runtime's controller of that hand, if there is one, gets its hand back.
#pragma once

#include <array>
#include <cstdint>

#include "layer/src/service/service_link.h"

namespace omni::layer {

struct RestLimits {
  // A hand that holds a pen still moves it more than this within seconds; the tracker's noise is well below.
  double still_m = 0.003;
  double still_rad = 0.05;                    // of the pen's axis
  std::int64_t still_ns = 20'000'000'000;     // this long without motion, contact and input: put down; <= 0: never
  double taken_up_m = 0.010;                  // moved this far from where it was put down: picked up again
  std::int64_t untracked_ns = 1'000'000'000;  // not tracked for this long: put down
};

class PenRest {
 public:
  // True: put down. From the samples that the syncs see; `pen` is present. Docked, still or unseen, see RestLimits.
  bool Update(const PenSnapshot& pen, const RestLimits& limits);
  // No pen: the next one starts from scratch.
  void Reset() { *this = PenRest(); }

 private:
  bool Moved(const PenSnapshot& pen, double distance_m, double angle_rad) const;
  void Hold(const PenSnapshot& pen);

  bool started_ = false;
  bool still_ = false;
  std::int64_t held_since_ns_ = 0;
  std::int64_t last_tracked_ns_ = 0;
  std::array<double, 3> position_base_m_{};
  std::array<double, 3> axis_base_{};
  std::int64_t last_input_ns_ = 0;
};

}  // namespace omni::layer
