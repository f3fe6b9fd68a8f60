#include "service/tools/hand/car_driver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "service/haptics/vehicle/wall_map.h"

namespace omni::tools {
namespace {

constexpr double kWidest_m = 0.1;       // half a road at most
constexpr double kRay_m = 1e-5;         // radius of the probing ray
constexpr std::size_t kLongest = 5000;  // points: 10 m of road

// Half way between the walls on both sides; false: one is missing.
bool ToMiddle(const haptics::WallMap& walls, const base::Vec3& ahead, base::Vec3& p) {
  const base::Vec3 left{-ahead.y, ahead.x, 0};
  const haptics::WallTouch to_left = haptics::FirstTouch(walls, p, kWidest_m * left, kRay_m);
  const haptics::WallTouch to_right = haptics::FirstTouch(walls, p, -kWidest_m * left, kRay_m);
  if (!to_left.found || !to_right.found) return false;
  p = p + (0.5 * kWidest_m * (to_left.share - to_right.share)) * left;
  return true;
}

}  // namespace

base::Result<TrackLine> TrackLine::Find(const haptics::Scene& scene) {
  const haptics::VehicleInput& car = scene.header().vehicle;
  const haptics::WallMap walls = haptics::WallsOf(scene);
  base::Vec3 ahead{std::cos(car.start_heading_rad), std::sin(car.start_heading_rad), 0};
  base::Vec3 p = car.start_base_m;
  std::vector<base::Vec3> points;
  while (points.size() < kLongest) {
    if (!ToMiddle(walls, ahead, p)) return base::Error{"the road has no wall on one of its sides"};
    if (!points.empty()) ahead = Normalized(p - points.back());
    const bool back = points.size() > 5 && Norm(p - points.front()) < kSpacing_m;
    if (back) return TrackLine(std::move(points));
    points.push_back(p);
    p = p + kSpacing_m * ahead;
  }
  return base::Error{"the road does not lead back to where the car starts"};
}

base::Vec3 TrackLine::At(double way_m) const noexcept {
  const auto count = static_cast<double>(points_.size());
  double at = std::fmod(way_m / kSpacing_m, count);
  if (at < 0) at += count;
  const auto i = std::min(static_cast<std::size_t>(at), points_.size() - 1);
  const double share = at - static_cast<double>(i);
  return points_[i] + share * (points_[(i + 1) % points_.size()] - points_[i]);
}

double TrackLine::Nearest(const base::Vec3& p, double near_m, double reach_m) const noexcept {
  double best_m = near_m, least_m = std::numeric_limits<double>::infinity();
  const double reach = std::min(reach_m, 0.5 * length_m());
  for (double way_m = near_m - reach; way_m <= near_m + reach; way_m += 0.5 * kSpacing_m) {
    const base::Vec3 off = At(way_m) - p;
    const double distance_m = std::hypot(off.x, off.y);
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    best_m = way_m;
  }
  return best_m;
}

// By the turn between two pieces of twice the spacing.
double TrackLine::Curvature_1_m(double from_m, double to_m) const noexcept {
  constexpr double h = 2 * kSpacing_m;
  double most_1_m = 0;
  for (double way_m = from_m; way_m <= to_m; way_m += kSpacing_m) {
    const base::Vec3 a = At(way_m) - At(way_m - h), b = At(way_m + h) - At(way_m);
    const double turn_rad = std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
    most_1_m = std::max(most_1_m, std::abs(turn_rad) / h);
  }
  return most_1_m;
}

}  // namespace omni::tools
