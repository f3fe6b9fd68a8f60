// Where the base stands in a headset's reference space: what is measured, what comes out, what is refused.
// Frames: L reference space (OpenXR: metres, y up), B base (z up), C controller (or a finger's joint). X_LB takes B to
// L. docs/theory/alignment.md has the equations. Never in the tick.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "service/base/vec.h"

namespace omni::alignment {

struct Rigid {
  base::Quat orientation;
  base::Vec3 position_m;
};

// At one time a point fixed to the controller (its tip) was at a point known in the base.
struct Sample {
  double t_s = 0;
  Rigid controller_space;        // X_LC
  base::Vec3 point_base_m;       // a mark, or the pen's tip
  base::Vec3 velocity_base_m_s;  // of that point; 0: a mark
  int group = 0;                 // which touch; samples of one group share what a hand does wrong there
};

// Prior knowledge, and its weight.
struct Prior {
  bool level = true;                 // the base stands on a level desk and L's y points up
  double level_sigma_rad = 0.00873;  // 0.5 degrees: desks, and the headset's idea of gravity
  base::Vec3 tip_controller_m;       // the tip in C
  double tip_sigma_m = 1;            // per axis; 1: unknown
  bool time_offset = false;          // controller and pen may be late against each other: solve for it
  double time_offset_sigma_s = 0.02;
  double noise_m = 1.5e-3;  // per axis and independent sample, what is expected ...
  double noise_weight = 4;  // ... counted as so many residuals
  bool robust = false;      // single samples may be wrong: weighs them down
};

// When to reject.
struct Limits {
  int samples_min = 3;
  double extent_min_m = 0.03;   // largest rms extent of the points is at least half of this
  double line_ratio_min = 0.1;  // second to first singular value of the points about their mean
  double plane_ratio_min = 0;   // third to first
  double rms_max_m = 5e-3;
  double expected_error_max_m = 8e-3;  // predicted
  double rotation_sigma_max_rad = 0.05;
  double tip_sigma_max_m = 6e-3;  // norm over axes; a finger's joint is near enough unfound
};

struct Outcome {
  Rigid base_space;  // X_LB
  base::Vec3 tip_controller_m;
  double time_offset_s = 0;       // the controller shows where the pen is this much later; < 0: it lags
  double rms_m = 0;               // of the residuals, norm over axes; weighed where robust
  double expected_error_m = 0;    // 1 sigma, norm over axes, at the working point: the quality figure
  double rotation_sigma_rad = 0;  // 1 sigma, norm over axes
  double tip_sigma_m = 0;         // 1 sigma, norm over axes
  double correlation = 1;         // samples that are worth one independent one
  int samples = 0;
  int groups = 0;
  int wrong_group = -1;                 // left out: it contradicts the others
  double wrong_by_m = 0;                // by so much
  std::array<double, 36> covariance{};  // of (rotation vector in L, position of B's origin in L), row-major
  std::vector<double> residual_m;       // per sample, norm
};

// Where the error is predicted: where the pen is used.
inline constexpr base::Vec3 kWorkingPoint_base_m{0, 0, 0.06};

inline constexpr double kUnknownTip_m = 1;

}  // namespace omni::alignment
