// Driving a car of a scene: the line of its road, and the stick that follows it.
#pragma once

#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_input.h"
#include "service/tools/hand/hand_task.h"

namespace omni::tools {

// Centre line of a road between two walls, as a driver sees it.

// A closed line in the plane that the car drives on, from its start in its direction.
class TrackLine {
 public:
  static constexpr double kSpacing_m = 0.002;

  // Walks along the road of a scene with a vehicle. Error: the road does not lead back to the start.
  static base::Result<TrackLine> Find(const haptics::Scene& scene);

  explicit TrackLine(std::vector<base::Vec3> points) : points_(std::move(points)) {}  // at least three

  double length_m() const noexcept { return kSpacing_m * static_cast<double>(points_.size()); }
  // Distance along the line to its point nearest to `p`; searches `reach_m` to both sides of `near_m`.
  double Nearest(const base::Vec3& p, double near_m, double reach_m) const noexcept;
  base::Vec3 At(double way_m) const noexcept;
  // Largest curvature between the two distances: 1 / radius.
  double Curvature_1_m(double from_m, double to_m) const noexcept;

 private:
  std::vector<base::Vec3> points_;  // kSpacing_m apart, nearly
};

// Drives a car by a stick, as a person does who sees it from above: looks ahead along the road, slows down for bends
// and after hits, backs off when it is stuck.
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
