// Drives a car by a stick, as a person does who sees it from above: looks ahead along the road, slows down for bends
// and after hits, backs off when it is stuck.
#pragma once

#include "service/haptics/scene/scene_input.h"
#include "service/tools/hand/perceived.h"
#include "service/tools/hand/track_line.h"

namespace omni::tools {

struct StickWish {
  double x = 0, y = 0;  // -1..1, |(x, y)| <= 1
};

class CarDriver {
 public:
  CarDriver(const haptics::VehicleInput& car, TrackLine line) : car_(car), line_(std::move(line)) {}

  // `dt_s`: since the last call.
  StickWish Steer(const PerceivedCar& seen, double dt_s);

 private:
  void Learn(const PerceivedCar& seen, double dt_s);
  bool BacksOff(const PerceivedCar& seen, double dt_s);
  // Look-ahead point on the road, relative to the predicted car: distance, and angle from straight ahead.
  struct Bearing {
    double distance_m, angle_rad;
  };
  Bearing LookAhead(const PerceivedCar& seen);
  double WantedSpeed_m_s(double angle_rad) const;

  const haptics::VehicleInput car_;
  const TrackLine line_;
  bool placed_ = false;  // way_m_ is known
  double way_m_ = 0;     // along the line
  double care_ = 0;      // 0..1: grows with hits, then fades
  std::uint32_t hits_ = 0;
  double stuck_s_ = 0;                   // how long it has stood still although it should drive
  double backing_s_ = 0;                 // left of backing off
  double wheel_rad_ = 0, wished_y_ = 0;  // last
};

}  // namespace omni::tools
