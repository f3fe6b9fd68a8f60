// Constant-velocity Kalman filter of the tool's pose: six states for the position (full covariance), two per tangent
// for the axis (isotropic). docs/theory/tracking.md (10) - (12)
#pragma once

#include <array>
#include <type_traits>

#include "service/base/vec.h"

namespace omni::tracker {

struct FilterNoise {
  double acceleration_m2_s3 = 1.0;            // spectral density of the position's acceleration, of a hand at work
  double angular_acceleration_rad2_s3 = 100;  // of the axis's
  // Both are multiplied by a factor that is learnt: innovations that follow one another mean that it is too small.
  double calm_log_min = -4.6;     // natural logarithms of 0.01 ...
  double calm_log_max = 2.3;      // ... and 10
  double calm_rate = 0.05;        // per scan
  double calm_memory = 0.2;       // share of the newest innovation in the mean of those before
  double white_min = 0.01;        // least share of a fit's variance that is taken for white
  double white_time_s = 0.05;     // over which it is learnt
  double manoeuvre_factor = 100;  // on both while the pen starts, stops or hits something
  double lag_memory = 0.2;        // share of the newest scan in what the filter is behind by
};

// How much the pen's motion deviates from a straight one, learnt from whether innovations follow one another.
struct Liveliness {
  double log_factor = 0;           // on the density of the acceleration
  std::array<double, 3> recent{};  // mean of the last innovations in their standard deviations
};

// Which part of the variance that a fit claims is white: a wrong model or calibration shifts every fit alike, which no
// filter can average away and no innovation shows. Learnt from third differences, in which motion vanishes.
struct Whiteness {
  std::array<base::Vec3, 3> last{};  // measurements, newest first
  int count = 0;
  double share = 1;
};

struct FilterState {
  base::Vec3 position_base_m, velocity_base_m_s;
  base::Vec3 axis_base{0, 0, -1}, angular_velocity_base_rad_s;
  std::array<double, 9> covariance_pp{}, covariance_pv{}, covariance_vv{};  // row-major, symmetric but for pv
  double variance_angle = 0, covariance_angle_rate = 0, variance_rate = 0;  // per tangent
  Liveliness position_liveliness, axis_liveliness;
  Whiteness position_whiteness, axis_whiteness;
  base::Vec3 lag_m;   // mean of what the last positions were ahead of the filter
  bool lags = false;  // by more than noise can make
};
static_assert(std::is_trivially_copyable_v<FilterState>);

// A pose as measured. covariance: of (position, tangents), row-major 5x5.
struct PoseMeasurement {
  base::Vec3 position_base_m, axis_base;
  std::array<double, 25> covariance{};
};

void ResetFilter(const PoseMeasurement& measured, FilterState& state) noexcept;
void PredictFilter(const FilterNoise& noise, double dt_s, FilterState& state) noexcept;
// dt_s: as in the prediction before. A pose that cannot follow from the prediction restarts the filter there.
void CorrectFilter(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s, FilterState& state) noexcept;

// u turned by the vector `turn_rad` (angle times axis).
base::Vec3 TurnAxis(const base::Vec3& axis, const base::Vec3& turn_rad) noexcept;

}  // namespace omni::tracker
