// Bounds on the stiffness and damping that a hand may get through a delayed, noisy, sampled loop.
// docs/theory/haptics.md, section 3.
#pragma once

#include <array>

#include "service/base/vec.h"
#include "service/haptics/haptics.h"
#include "service/haptics/state.h"

namespace omni::haptics {

using base::Vec3;

// The bounds of one tick, and the loop's times.
struct StiffnessBound {
  double stiffness_N_m = 0;  // in the worst direction
  double along_N_m = 0;      // along the pen's axis, at least that
  Vec3 axis_base;            // unit, or zero
  double damping_Ns_m = 0;
  double predict_s = 0;  // the tip is predicted this far ahead
  double ahead_s = 0;    // from there to when the current acts
  double coil_lag_s = 0;
};

// From a sample's instant to the middle of the time for which the resulting current is held; not a number if the delay
// is invalid.   (3.1)
double LoopLag_s(const Config& config, const Input& input) noexcept;

// Stiffness bound along a unit direction   (3.5)
double StiffnessAlong(const StiffnessBound& bound, const Vec3& direction) noexcept;

// Largest stiffness while the tip is predicted by `predict_s`; zero if an input is not a number.   (3.2)-(3.4)
double StiffnessLimit(const Config& config, const Input& input, const base::PointNoise& noise,
                      double predict_s) noexcept;

// The prediction, 0 to the whole lag in quarters, that allows the largest stiffness; none unless it gains a fifth.
double BestPrediction_s(const Config& config, const Input& input) noexcept;

// Follows the limits: up and down in the air, only down in contact, where every change of stiffness would move the
// hand.
StiffnessBound UpdateStiffnessBound(const Config& config, const Input& input, bool touching,
                                    StiffnessBoundState& state) noexcept;

// What UpdateStiffnessBound returned last, without the times.
StiffnessBound StiffnessBoundOf(const Vec3& axis_base, const StiffnessBoundState& state) noexcept;

// Springs K_i along unit n_i add up to sum K_i n_i n_i', whose largest eigenvalue is at most
// max_i sum_j K_j |n_i . n_j|   (Gershgorin on the Gram matrix, 3.7). With `load` = K_i over the bound along n_i: the
// factor that brings this bound to 1.
double StiffnessShare(const std::array<Vec3, kMaxContacts>& normals,
                      const std::array<double, kMaxContacts>& load) noexcept;

}  // namespace omni::haptics
