// Fixed-size Levenberg-Marquardt on position and direction. No allocation, bounded work.
#pragma once

#include <Eigen/Core>

#include "service/tracker/kernel/linearise.h"

namespace omni::tracker {

using Matrix5d = Eigen::Matrix<double, kParameters, kParameters>;

struct Pose {
  Eigen::Vector3d position_base_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_base = -Eigen::Vector3d::UnitZ();  // unit
};

inline constexpr double kColdDamping = 1e-2;

struct SolveOptions {
  Precision precision = Precision::kDouble;
  int parameters = kParameters;  // 3: the axis is held, its covariance is zero
  int iterations_max = 20;       // evaluations of the model
  double damping = 0;            // 0 trusts the start (warm), > 0 steps carefully at first (cold: kColdDamping)
  bool chord = true;  // a short first step may be followed by one with the same derivatives: a warm start only
  bool take_every_step = false;    // exactly iterations_max Gauss-Newton steps, none refused: for benches
  KernelSums* sums = nullptr;      // where the search ended, of all columns and the moment: Fit::has_sums
  const Kernel* kernel = nullptr;  // null: ActiveKernel()
};

struct Fit {
  Pose pose;
  double chi2 = 0;
  int iterations = 0;      // evaluations of the model
  bool converged = false;  // the last step was a small fraction of its own standard deviation
  bool has_sums = false;   // SolveOptions::sums was written: derivatives and residuals at or next to the pose
  // (J^T J)^-1 in (position, turn about the tangents of magnetics::MakeTangentBasis(axis)).
  Matrix5d covariance = Matrix5d::Zero();
};

// Minimises |r|^2 from `start`.
template <int kCapacity>
Fit SolvePose(const Model& model, const BasicMeasurement<kCapacity>& measurement, const Pose& start,
              const SolveOptions& options) noexcept;
extern template Fit SolvePose(const Model&, const Measurement&, const Pose&, const SolveOptions&) noexcept;
extern template Fit SolvePose(const Model&, const ArrayMeasurement&, const Pose&, const SolveOptions&) noexcept;

inline Fit SolvePose(const Model& model, const Measurement& measurement, const Pose& start, double damping,
                     int iterations_max) noexcept {
  return SolvePose(model, measurement, start, {.iterations_max = iterations_max, .damping = damping});
}

PosePoint MakePosePoint(const Pose& pose) noexcept;

// Finds the tool without a hint. docs/theory/tracking.md (6.2), (6.3)
inline constexpr int kColdCandidates = 6;      // in the tick
inline constexpr int kColdCandidatesMax = 24;  // off it

struct ColdCandidates {
  int count = 0;
  std::array<Pose, kColdCandidatesMax> poses;
};

// The best `wanted` places of the model's grid, best first, each with the direction that fits best there.
template <int kCapacity>
ColdCandidates RankGrid(const Model& model, const BasicMeasurement<kCapacity>& measurement,
                        int wanted = kColdCandidates) noexcept;
extern template ColdCandidates RankGrid(const Model&, const Measurement&, int) noexcept;
extern template ColdCandidates RankGrid(const Model&, const ArrayMeasurement&, int) noexcept;

}  // namespace omni::tracker
