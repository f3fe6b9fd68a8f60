#include "service/tools/hand/car_driver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/haptics/vehicle/car_motion.h"
#include "service/haptics/vehicle/joystick.h"

namespace omni::tools {
namespace {

constexpr double kAnticipation_s = 0.12;  // delay of eyes, arm and stick
constexpr double kLookAhead_s = 0.12;     // at the car's speed, on top of ...
constexpr double kLookAheadLeast_m = 0.008;
constexpr double kCruise = 0.8;     // of the top speed, on a free road
constexpr double kCrawl = 0.25;     // at least
constexpr double kGripShare = 0.5;  // of the grip, in bends
constexpr double kBendAhead_m = 0.02;
constexpr double kCarePerHit = 0.35, kCareFades_1_s = 0.04;
constexpr double kCareTakes = 0.6;  // of the speed, at most
constexpr double kStill = 0.06;     // of the top speed: as good as standing
constexpr double kStuck_s = 0.6;
constexpr double kBacking_s = 0.9;
constexpr double kSearch_m = 0.02;  // along the line, about where the car was

StickWish Limited(double x, double y) {
  x = std::clamp(x, -0.95, 0.95);
  const double most = std::sqrt(1 - x * x);
  return {x, std::clamp(y, -most, most)};
}

}  // namespace

StickWish CarDriver::Steer(const PerceivedCar& seen, double dt_s) {
  Learn(seen, dt_s);
  const Bearing bearing = LookAhead(seen);
  StickWish wish;
  wheel_rad_ = 0;
  if (BacksOff(seen, dt_s)) {
    // Backwards the front turns away from where the wheels point.
    wish = Limited(std::copysign(0.9, bearing.angle_rad), -1);
  } else {
    // The circle through the look-ahead point [Coulter 1992, pure pursuit]: curvature 2 sin(angle) / distance.
    const double angle_rad = std::clamp(bearing.angle_rad, -std::numbers::pi / 2, std::numbers::pi / 2);
    wheel_rad_ = std::atan(car_.wheelbase_m * 2 * std::sin(angle_rad) / bearing.distance_m);
    wheel_rad_ = std::clamp(wheel_rad_, -car_.steer_max_rad, car_.steer_max_rad);
    wish = Limited(-wheel_rad_ / car_.steer_max_rad, WantedSpeed_m_s(bearing.angle_rad) / car_.speed_max_m_s);
  }
  wished_y_ = wish.y;
  return wish;
}

// Drives more carefully for a while after hitting a wall.
void CarDriver::Learn(const PerceivedCar& seen, double dt_s) {
  care_ = std::max(0.0, care_ - kCareFades_1_s * dt_s);
  if (placed_ && seen.hits > hits_) care_ = std::min(1.0, care_ + kCarePerHit);
  hits_ = seen.hits;
}

bool CarDriver::BacksOff(const PerceivedCar& seen, double dt_s) {
  if (backing_s_ > 0) {
    backing_s_ -= dt_s;
    return backing_s_ > 0;
  }
  const bool stands = std::abs(seen.speed_m_s) < kStill * car_.speed_max_m_s;
  stuck_s_ = stands && wished_y_ > 0 ? stuck_s_ + dt_s : 0;
  if (stuck_s_ < kStuck_s) return false;
  stuck_s_ = 0;
  backing_s_ = kBacking_s;
  return true;
}

CarDriver::Bearing CarDriver::LookAhead(const PerceivedCar& seen) {
  // Predicted position on the arc that it is steered along.
  const double way_m = kAnticipation_s * seen.speed_m_s;
  const double turn_rad = way_m * std::tan(wheel_rad_) / car_.wheelbase_m;
  const double middle_rad = seen.heading_rad + 0.5 * turn_rad;
  const base::Vec3 place = seen.position_base_m + way_m * base::Vec3{std::cos(middle_rad), std::sin(middle_rad), 0};
  way_m_ = line_.Nearest(place, way_m_, placed_ ? kSearch_m : line_.length_m());
  placed_ = true;
  const double look_m = kLookAheadLeast_m + kLookAhead_s * std::max(0.0, seen.speed_m_s);
  const base::Vec3 to = line_.At(way_m_ + look_m) - place;
  return {std::max(1e-3, std::hypot(to.x, to.y)),
          std::remainder(std::atan2(to.y, to.x) - seen.heading_rad - turn_rad, 2 * std::numbers::pi)};
}

double CarDriver::WantedSpeed_m_s(double angle_rad) const {
  const double bend_1_m = std::max(1e-3, line_.Curvature_1_m(way_m_, way_m_ + kBendAhead_m));
  const double grip_m_s = std::sqrt(kGripShare * car_.grip_g * haptics::kGravity_m_s2 / bend_1_m);
  const double free_m_s = std::min(kCruise * car_.speed_max_m_s, grip_m_s) * (1 - kCareTakes * care_);
  const double straight = std::max(0.0, 1 - std::abs(angle_rad));  // it points elsewhere: slowly
  return std::max(kCrawl * car_.speed_max_m_s, straight * free_m_s);
}

}  // namespace omni::tools
