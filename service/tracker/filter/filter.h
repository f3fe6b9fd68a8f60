// Filter of the tool's pose with three models of the hand's motion: at rest, at constant velocity, and manoeuvring (it
// starts, stops or turns). Each has its own estimate, weighted by its probability. Position: six states, full
// covariance; axis: two per tangent, isotropic. docs/theory/tracking.md (7.1) - (7.5)
#pragma once

#include <array>
#include <type_traits>

#include "service/base/tool_state.h"
#include "service/base/vec.h"
#include "service/tracker/filter/interacting_models.h"

namespace omni::tracker {

// Models of the motion.
inline constexpr std::size_t kAtRest = 0, kConstantVelocity = 1, kManoeuvre = 2;

struct FilterNoise {
  // At rest: no faster than this, about a position that wanders.
  double rest_speed_m_s = 1e-3, rest_rate_rad_s = 1e-2;
  double rest_wander_m2_s = 8e-6, rest_wander_rad2_s = 7e-4;
  double rest_wander_share = 0.05;  // share of a measurement's variance per scan, at most
  // Constant velocity: spectral densities of the acceleration of position and axis for a working hand. Both are
  // multiplied by a learnt factor: correlated innovations mean that it is too small.
  double acceleration_m2_s3 = 1.0, angular_acceleration_rad2_s3 = 100;
  double calm_log_min = -4.6;    // natural logarithms of 0.01 ...
  double calm_log_max = 2.3;     // ... and 10
  double calm_rate = 0.05;       // per scan
  double calm_memory = 0.2;      // weight of the newest innovation in the running mean
  double manoeuvre_factor = 20;  // on both densities, for a manoeuvre
  // Transition rates between the models, from row to column.
  TransitionRates follows_1_s{{{0, 40, 20}, {0.5, 0, 3}, {1, 450, 0}}};
  // While a force pushes the pen: it is not at rest, and waiting until it surely moves would delay the estimate and
  // with it the force.
  TransitionRates follows_pushed_1_s{{{0, 2000, 20}, {0, 0, 3}, {0, 450, 0}}};
  Likely likely_at_first{0.2, 0.6, 0.2};
  double white_min = 0.01;     // least share of a fit's variance that is taken as white
  double white_time_s = 0.05;  // time over which the share is learnt
  double lasting_s = 0.01;     // averaging time of the other part, so that an uninformative scan does not count
};

// How much the pen's motion deviates from a straight one, learnt from the correlation of successive innovations.
struct Liveliness {
  double log_factor = 0;           // on the density of the acceleration
  std::array<double, 3> recent{};  // mean of the last innovations in their standard deviations
};

// Which part of the variance that a fit claims is white: a wrong model or calibration shifts every fit alike, which no
// filter can average away and no innovation shows. Learnt from third differences, in which motion vanishes.
struct Whiteness {
  std::array<base::Vec3, 3> last{};  // measurements, newest first
  int count = 0;
  double share = 1;  // of a position: across the direction from the core
  double along = 1;  // of a position: along it, where distance is known better and the model's error counts for more
};

struct Motion {
  base::Vec3 position_base_m, velocity_base_m_s;
  std::array<double, 9> covariance_pp{}, covariance_pv{}, covariance_vv{};  // row-major, symmetric but for pv
};

struct Turning {
  base::Vec3 axis_base{0, 0, -1}, angular_velocity_base_rad_s;              // perpendicular to each other
  double variance_angle = 0, covariance_angle_rate = 0, variance_rate = 0;  // per tangent
};

// The combined estimate of all models, and the models' own.
struct FilterState : Motion, Turning {
  Models<Motion> motions;
  Models<Turning> turnings;
  Liveliness position_liveliness, axis_liveliness;
  Whiteness position_whiteness, axis_whiteness;
  std::array<double, 9> white_m2{};    // of the last position, row-major
  std::array<double, 9> lasting_m2{};  // of the covariance of positions, the part that is not white, row-major
  double lasting_rad2 = 0;             // of an axis, per tangent
};
static_assert(std::is_trivially_copyable_v<FilterState>);

// A pose as measured. covariance: of (position, tangents), row-major 5x5.
struct PoseMeasurement {
  base::Vec3 position_base_m, axis_base;
  std::array<double, 25> covariance{};
};

void ResetFilter(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept;
// pushed: a force acts on the pen.
void PredictFilter(const FilterNoise& noise, double dt_s, bool pushed, FilterState& state) noexcept;
// dt_s: as in the prediction before. A pose that cannot follow from the prediction restarts the filter there.
void CorrectFilter(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s, FilterState& state) noexcept;

// u turned by the vector `turn_rad` (angle times axis).
base::Vec3 TurnAxis(const base::Vec3& axis, const base::Vec3& turn_rad) noexcept;

// The noise of a tracked point as it enters a force (docs/theory/haptics.md, section 3), in the worst direction; of a
// point `offset_m` along the axis from the magnet's centre.
base::PointNoise NoiseOfPoint(const FilterState& filter, double offset_m) noexcept;

// Along the axis, where a small tilt moves nothing.
base::PointNoise NoiseAlong(const FilterState& filter) noexcept;

}  // namespace omni::tracker
