// The normal equations of the whole recording: array unknowns on one side, each sample's own unknowns on the other.
// docs/theory/calibration.md (1.1), (3.2), (4.1), (4.2)
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/calibration/fit/parameters.h"
#include "service/calibration/fit/residual.h"
#include "service/calibration/types.h"
#include "service/magnetics/coil.h"

namespace omni::calibration {

using OwnVector = Eigen::Matrix<double, kOwn, 1>;
using OwnMatrix = Eigen::Matrix<double, kOwn, kOwn>;

struct Instant {
  Eigen::Vector3d position_base_m;
  Eigen::Vector3d axis_base;
  Eigen::Vector3d remanence = Eigen::Vector3d::Zero();  // in units of Tolerances::remanence_A
};
// `step` as OwnVector: metres, radians, units of the tolerance.
Instant MovedInstant(const Instant& instant, const OwnVector& step);

// A sample made ready: what is left for the tool, and how much each axis is to be trusted.
struct Observation {
  double tau = 0;  // [-1, 1] over the recording
  bool touches_hull = false;
  double weight = 1;        // robust: of the readings ...
  double touch_weight = 1;  // ... and of the touch
  int readings = 0;         // usable axes
  double t_s = 0;
  // By the core, as currents, against the last motion, length 1: of a pen that moves, and of one that rests and
  // trembles.
  Eigen::Matrix<double, 3, 2> kept = Eigen::Matrix<double, 3, 2>::Zero();
  std::vector<Eigen::Vector3d> tool_sensor_T;
  std::vector<Eigen::Vector3d> inverse_sigma;  // 0: not used
};

// One sample's part: own block, coupling to the array, and what is left over.
struct SampleBlock {
  OwnMatrix H;
  OwnVector g;
  Eigen::Matrix<double, kOwn, Eigen::Dynamic> C;
  double chi2 = 0;        // of the readings, unweighted
  double touch_chi2 = 0;  // unweighted
  double cost = 0;        // weighted, with the prior of the remanence
};

// How one sensor's readings fit, weights included.
struct SensorFit {
  double chi2 = 0;
  double square_T2 = 0;  // sum of squared residuals
  double readings = 0;   // sum of weights
};

struct System {
  Eigen::MatrixXd H;  // array block, priors included
  Eigen::VectorXd g;
  std::vector<SampleBlock> samples;
  std::vector<SensorFit> sensors;
  double map_chi2 = 0;  // of the current maps against the coils' shape
  int map_readings = 0;
  double cost = 0;
};

// What does not change while the unknowns do.
class Problem {
 public:
  // `coils`: nominal; empty: their shapes are not used, and only the tolerances fix the frame.
  Problem(const base::Calibration& nominal, std::span<const base::CoilGeometry> coils, const Recording& recording,
          const Tolerances& tolerances);

  std::vector<Observation>& observations() { return observations_; }
  const std::vector<Observation>& observations() const { return observations_; }
  const base::Calibration& nominal() const { return nominal_; }
  double touch_sigma_m() const { return touch_sigma_m_; }
  double remanence_A() const { return remanence_A_; }
  bool has_coils() const { return !coil_moments_.empty(); }
  bool follows_core() const { return !core_current_A_T_.isZero(); }

  // Updates the core's remanence, which trails the magnet's path through these instants by the amount that the core has
  // been found to keep.
  void FollowCore(const Parameters& parameters, std::span<const Instant> instants);

  System Linearise(const Parameters& parameters, std::span<const Instant> instants) const;

 private:
  Eigen::Vector3d CoreCurrents_A(const Instant& instant) const;
  void AddPriors(const Parameters& parameters, System& system) const;
  void AddMaps(const Parameters& parameters, System& system) const;

  base::Calibration nominal_;  // maps and background replaced by measured ones
  double touch_sigma_m_;
  double remanence_A_;
  Eigen::Matrix3d core_current_A_T_ = Eigen::Matrix3d::Zero();  // magnetics::CoreCurrents
  std::vector<Observation> observations_;
  std::vector<double> map_error_T_A_;  // per sensor; empty: nominal maps
  struct CoilShape {
    magnetics::CoilMoments winding, core;
  };
  std::vector<CoilShape> coil_moments_;  // per coil
};

inline constexpr double kGaugeWeight = 1e6;  // the mean gain is 1 within 1e-3 tolerances
// The direction in which all gains grow together: not observable beside the moment, held at zero. (3.1)
Eigen::VectorXd GainScaleDirection(const Parameters& parameters);

}  // namespace omni::calibration
