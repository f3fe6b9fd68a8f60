// The unknowns of an array, in units of their tolerance: the drawing is 0, and every prior has variance 1.
// docs/theory/calibration.md (2.1), (3.1)
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/calibration/types.h"

namespace omni::calibration {

// Of one sensor: position (3), gain per axis (3), rotation (3), skew (3).
inline constexpr int kSensorUnknowns = 12;
inline constexpr int kPositionAt = 0, kGainAt = 3, kRotationAt = 6, kSkewAt = 9;

// Shared ones follow the sensors'. The first group acts on samples, hull and centre on their touches; the rest, the
// core's centre and steel on current maps.
inline constexpr int kMomentAt = 0, kMomentDriftAt = 1, kMomentBowAt = 2, kKappaAt = 3, kAmbientAt = 4,
                     kAmbientDriftAt = 7, kHullAt = 10, kCentreAt = 11, kSteelAt = 14, kSteelDepthAt = 15, kKeptAt = 16;
inline constexpr int kSampleShared = 18;
inline constexpr int kStrengthAt = 18, kTiltAt = 21;  // coil: strength (3), tilt about two axes (3 x 2)
inline constexpr int kShared = 27;

inline constexpr double kSteelDepth_m = 0.18;  // where steel is searched for at first, below the core's centre
inline constexpr double kBowOfDrift = 0.5;     // a warming that levels off bends by less than it drifts

// A sensor as the unknowns have it: reading = gain (B + ambient) + map I.
struct SensorState {
  Eigen::Vector3d position_base_m;
  Eigen::Matrix3d error;    // E = I + D, D of gains, rotation and skew
  Eigen::Matrix3d nominal;  // nominal gain
  Eigen::Matrix3d gain;     // E nominal
};

// Unknowns of the steel under the base. Steel of no strength has no place.
enum class SteelFit : std::uint8_t { kNone, kStrength, kStrengthAndDepth };

class Parameters {
 public:
  Parameters(const base::Calibration& nominal, const Tolerances& tolerances);

  int sensors() const { return sensors_; }
  int size() const { return kSensorUnknowns * sensors_ + kShared; }
  int shared_at() const { return kSensorUnknowns * sensors_; }

  Eigen::VectorXd& x() { return x_; }
  const Eigen::VectorXd& x() const { return x_; }

  SensorState Sensor(int i) const;
  // tau in [-1, 1] over the recording.
  double Moment_Am2(double tau) const;
  double Kappa() const;
  Eigen::Vector3d Ambient_T(double tau) const;
  double HullRadius_m() const;
  // Of the core, from the centre of hull and windings. Sensors and samples are measured from the core while they are
  // adjusted: so their readings do not depend on it.
  Eigen::Vector3d CoreCentre_m() const;
  Eigen::Vector2d Kept() const;    // by the core of a motion, in units of Tolerances::remanence_A
  double Kept_A() const;           // of a pen that moves
  base::SteelPlane Steel() const;  // height above the core's centre
  // What is no unknown is held: the depth at kSteelDepth_m, as at first, the strength at none.
  void SetSteelFit(SteelFit fit);
  double SteelStrengthStep() const;                          // derivative of Steel()'s strength by its unknown ...
  double SteelHeightStep_m() const;                          // ... and of its height
  double CoilStrength(int coil) const;                       // factor
  Eigen::Vector3d CoilTilt(int coil) const;                  // rotation vector, B
  Eigen::Matrix<double, 3, 2> CoilTiltAxes(int coil) const;  // perpendicular to the coil's axis

  // Derivative of E b by the nine gain, rotation and skew unknowns.
  Eigen::Matrix<double, 3, 9> GainJacobian(const Eigen::Vector3d& b) const;

  const Tolerances& tolerances() const { return tolerances_; }
  const base::Calibration& nominal() const { return nominal_; }
  void SetCoilAxes(const std::array<Eigen::Vector3d, base::kCoilCount>& axes_base) { coil_axes_ = axes_base; }
  const Eigen::Vector3d& CoilAxis(int coil) const { return coil_axes_[static_cast<std::size_t>(coil)]; }

  std::string Name(int index) const;        // "sensor 3 position x"
  std::string Unit(int index) const;        // "mm"
  double ToleranceInUnit(int index) const;  // one standard deviation

 private:
  base::Calibration nominal_;
  Tolerances tolerances_;
  int sensors_;
  Eigen::VectorXd x_;
  SteelFit steel_fit_ = SteelFit::kStrength;
  std::array<Eigen::Vector3d, base::kCoilCount> coil_axes_{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                                           Eigen::Vector3d::UnitZ()};
};

// Second Legendre polynomial: a drift that bends.
inline double Bow(double tau) { return 0.5 * (3 * tau * tau - 1); }

}  // namespace omni::calibration
