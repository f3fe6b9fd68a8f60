// Centre line of a road between two walls, as a driver sees it.
#pragma once

#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"

namespace omni::tools {

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

}  // namespace omni::tools
