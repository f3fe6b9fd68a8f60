// One pose from one set of readings of any array, without filter or history: for recordings, calibration and benches.
// Deterministic; set-up allocates, solving does not.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/tracker/solve/solver.h"

namespace omni::tracker {

struct StaticOptions {
  // Noise of the calibration's sensors only, and currents as measured. currents_hidden and ambient_error_T make
  // unknowns of them; model_error_relative adds the calibration's own error.
  Trust trust = NoiseOnly();
  Rung rung = Rung::kFull;
  Precision precision = Precision::kDouble;
  int parameters = kParameters;  // 3: the axis of the start is held
  int warm_iterations_max = 20;
  int cold_iterations_max = 40;
  int cold_candidates = 12;  // starts tried before the best poor fit is taken
  double chi2_max = 80;      // gate at 19 degrees of freedom, scaled to others; infinite: the best fit is always good
};

enum class StaticStatus : std::uint8_t {
  kFound,    // chi2 passes the gate
  kPoorFit,  // the best fit there is, but the readings contradict it: another magnet, a bad sensor, wrong noise
  kNoFit,    // nothing converged
  kTooFew    // not enough usable readings
};

struct StaticPose {
  StaticStatus status = StaticStatus::kNoFit;
  bool cold = false;  // found without the start
  Pose pose;
  Matrix5d covariance = Matrix5d::Zero();  // of (position, tangents of magnetics::MakeTangentBasis(axis))
  double chi2 = 0;
  int dof = 0;
  int iterations = 0;  // evaluations of the model, all starts together
  // Reading minus model, in the sensor's axes, nuisances at their best; NaN where not used. 3 * sensors entries.
  std::array<double, std::size_t{3} * kArraySensors> residual_T{};
  // Best values of the unknowns that trust allowed: what is left of the currents (A), then the ambient field (T).
  std::array<double, kNuisancesMax> nuisance{};
};

class StaticSolver {
 public:
  // Errors name the field: number of sensors, noise, moment, size of the magnet, anything not finite.
  static base::Result<StaticSolver> Make(const base::Calibration& calibration, const StaticOptions& options);

  // `readings`: one per sensor of the calibration. With a start: warm first, then cold unless the fit is good.
  StaticPose Solve(std::span<const ArrayReading> readings, const std::array<double, base::kCoilCount>& coil_current_A,
                   const std::optional<Pose>& start = std::nullopt) const noexcept;

  const Model& model() const noexcept { return model_; }
  const StaticOptions& options() const noexcept { return options_; }

 private:
  StaticSolver(Model model, const StaticOptions& options);

  Model model_;
  StaticOptions options_;
};

// chi2_max of 19 degrees of freedom scaled to others: the mean and as many standard deviations.
// docs/theory/tracking.md (6.1)
double ChiSquareGate(double chi2_max, int dof) noexcept;

}  // namespace omni::tracker
