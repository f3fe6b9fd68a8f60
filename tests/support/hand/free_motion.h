// A pen waved freely about the base: smooth, seeded, never cutting the hull, as fast as asked for and no faster.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/sim/coils/plant.h"
#include "service/sim/fields/tremor.h"

namespace omni::sim {

struct MotionOptions {
  std::uint64_t seed = 1;
  double radius_max_m = 0.1;              // of the magnet's centre, a ball about the base's origin
  double gap_min_m = 0;                   // to the hull
  double elevation_min_rad = 0;           // of the centre above the base's plane
  double tilt_max_rad = 1.0471975511966;  // of the axis from the inward radius
  double speed_max_m_s = 0.5;             // of the magnet's centre; slows down to nearly zero now and then
  double turn_rate_max_rad_s = 5;         // of its axis
  double tremor_m = 0;                    // rms, 8-12 Hz, on top of the speed
};

class FreeMotion final : public PenMotion {
 public:
  // Precondition: `duration_s` > 0; radius_max_m leaves room for the tilt above the hull.
  FreeMotion(const base::DeviceGeometry& device, const MotionOptions& options, double duration_s);

  State StateAt(double t_s) const noexcept override;  // 0 <= t <= duration
  MagnetPose Pose(double t_s) const noexcept override;

 private:
  // A smooth function of the path parameter: a sum of waves, bounded later as x / sqrt(1 + x^2).
  struct Coordinate {
    struct Wave {
      double rate, phase;
    };
    std::array<Wave, 4> waves;
    double At(double s) const noexcept;
  };
  MagnetPose PoseAt(double s) const noexcept;
  double RateAt(double t_s, double s) const noexcept;      // ds/dt, wanted
  std::array<double, 2> Along(double t_s) const noexcept;  // s and ds/dt, from the knots
  double ContactRadius(double tilt_rad) const noexcept;

  base::MagnetGeometry magnet_;
  double hull_radius_m_;
  MotionOptions options_;
  std::array<Coordinate, 5> coordinates_;  // direction 2, radius 1, tilt 2
  Coordinate pace_;
  Tremor tremor_;
  // s(t) on a grid of kGrid_s with its slope; between them the cubic through both [Hermite].
  struct Knot {
    double s, rate;
  };
  std::vector<Knot> knots_;
};

}  // namespace omni::sim
