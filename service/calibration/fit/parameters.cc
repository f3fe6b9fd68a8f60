#include "service/calibration/fit/parameters.h"

#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Label {
  const char* name;
  const char* unit;
  double scale;  // SI to unit
};
constexpr Label kSensorLabels[4] = {{"position", "mm", 1e3},
                                    {"gain", "%", 1e2},
                                    {"rotation", "deg", 57.29577951308232},
                                    {"skew", "deg", 57.29577951308232}};
constexpr Label kSharedLabels[kShared] = {{"moment", "%", 1e2},
                                          {"moment drift", "%", 1e2},
                                          {"moment bow", "%", 1e2},
                                          {"core kappa", "%", 1e2},
                                          {"ambient x", "uT", 1e6},
                                          {"ambient y", "uT", 1e6},
                                          {"ambient z", "uT", 1e6},
                                          {"ambient drift x", "uT", 1e6},
                                          {"ambient drift y", "uT", 1e6},
                                          {"ambient drift z", "uT", 1e6},
                                          {"hull radius", "mm", 1e3},
                                          {"core centre x", "mm", 1e3},
                                          {"core centre y", "mm", 1e3},
                                          {"core centre z", "mm", 1e3},
                                          {"steel strength", "%", 1e2},
                                          {"steel depth", "%", 1e2},
                                          {"core memory", "mA", 1e3},
                                          {"core memory at rest", "mA", 1e3},
                                          {"coil x strength", "%", 1e2},
                                          {"coil y strength", "%", 1e2},
                                          {"coil z strength", "%", 1e2},
                                          {"coil x tilt 1", "deg", 57.29577951308232},
                                          {"coil x tilt 2", "deg", 57.29577951308232},
                                          {"coil y tilt 1", "deg", 57.29577951308232},
                                          {"coil y tilt 2", "deg", 57.29577951308232},
                                          {"coil z tilt 1", "deg", 57.29577951308232},
                                          {"coil z tilt 2", "deg", 57.29577951308232}};

double SensorTolerance(const Tolerances& t, int kind) {
  const double sizes[4] = {t.sensor_position_m, t.sensor_gain, t.sensor_rotation_rad, t.sensor_skew_rad};
  return sizes[kind];
}

double SharedTolerance(const Tolerances& t, int at) {
  if (at == kMomentAt) return t.moment;
  if (at == kMomentDriftAt) return t.moment_drift;
  if (at == kMomentBowAt) return kBowOfDrift * t.moment_drift;
  if (at == kKappaAt) return t.core_kappa;
  if (at < kHullAt) return t.ambient_T;
  if (at == kHullAt) return t.hull_radius_m;
  if (at < kSteelAt) return t.core_centre_m;
  if (at == kKeptAt || at == kKeptAt + 1) return t.core_kept_A;
  if (at < kStrengthAt) return at == kSteelAt ? t.steel_strength : t.steel_depth;
  return at < kTiltAt ? t.coil_strength : t.coil_axis_rad;
}

}  // namespace

Parameters::Parameters(const base::Calibration& nominal, const Tolerances& tolerances)
    : nominal_(nominal),
      tolerances_(tolerances),
      sensors_(static_cast<int>(nominal.sensors.size())),
      x_(Eigen::VectorXd::Zero(size())) {}

SensorState Parameters::Sensor(int i) const {
  const base::SensorCalibration& drawn = nominal_.sensors[static_cast<std::size_t>(i)];
  const auto x = x_.segment<kSensorUnknowns>(kSensorUnknowns * i);
  const Vector3d gain = tolerances_.sensor_gain * x.segment<3>(kGainAt);
  const Vector3d turn = tolerances_.sensor_rotation_rad * x.segment<3>(kRotationAt);
  const Vector3d skew = tolerances_.sensor_skew_rad * x.segment<3>(kSkewAt);
  SensorState state;
  state.position_base_m =
      base::ToEigen(drawn.position_base_m) + tolerances_.sensor_position_m * x.segment<3>(kPositionAt);
  state.nominal = Eigen::Map<const RowMajor3d>(drawn.gain_sensor_base.data());
  state.error << 1 + gain.x(), skew.z() - turn.z(), skew.y() + turn.y(),  //
      skew.z() + turn.z(), 1 + gain.y(), skew.x() - turn.x(),             //
      skew.y() - turn.y(), skew.x() + turn.x(), 1 + gain.z();
  state.gain = state.error * state.nominal;
  return state;
}

Eigen::Matrix<double, 3, 9> Parameters::GainJacobian(const Vector3d& b) const {
  Matrix3d gain = b.asDiagonal(), turn, skew;
  turn << 0, b.z(), -b.y(), -b.z(), 0, b.x(), b.y(), -b.x(), 0;
  skew << 0, b.z(), b.y(), b.z(), 0, b.x(), b.y(), b.x(), 0;
  Eigen::Matrix<double, 3, 9> J;
  J << tolerances_.sensor_gain * gain, tolerances_.sensor_rotation_rad * turn, tolerances_.sensor_skew_rad * skew;
  return J;
}

double Parameters::Moment_Am2(double tau) const {
  const auto x = x_.tail<kShared>();
  return nominal_.moment_Am2 *
         (1 + tolerances_.moment * x[kMomentAt] +
          tolerances_.moment_drift * (x[kMomentDriftAt] * tau + kBowOfDrift * x[kMomentBowAt] * Bow(tau)));
}

double Parameters::Kappa() const { return nominal_.core_kappa + tolerances_.core_kappa * x_.tail<kShared>()[kKappaAt]; }

Vector3d Parameters::Ambient_T(double tau) const {
  const auto x = x_.tail<kShared>();
  return tolerances_.ambient_T * (x.segment<3>(kAmbientAt) + tau * x.segment<3>(kAmbientDriftAt));
}

double Parameters::HullRadius_m() const {
  return nominal_.hull_radius_m + tolerances_.hull_radius_m * x_.tail<kShared>()[kHullAt];
}

Vector3d Parameters::CoreCentre_m() const {
  return tolerances_.core_centre_m * x_.tail<kShared>().segment<3>(kCentreAt);
}

Eigen::Vector2d Parameters::Kept() const {
  return tolerances_.core_kept_A / tolerances_.remanence_A * x_.tail<kShared>().segment<2>(kKeptAt);
}

double Parameters::Kept_A() const { return tolerances_.core_kept_A * x_.tail<kShared>()[kKeptAt]; }

base::SteelPlane Parameters::Steel() const {
  const auto x = x_.tail<kShared>();
  return {tolerances_.steel_strength * x[kSteelAt],
          -kSteelDepth_m * std::exp(tolerances_.steel_depth * x[kSteelDepthAt])};
}

void Parameters::SetSteelFit(SteelFit fit) {
  steel_fit_ = fit;
  auto x = x_.tail<kShared>();
  if (fit != SteelFit::kStrengthAndDepth) x[kSteelDepthAt] = 0;
  if (fit == SteelFit::kNone) x[kSteelAt] = 0;
}

double Parameters::SteelStrengthStep() const {
  return steel_fit_ == SteelFit::kNone ? 0.0 : tolerances_.steel_strength;
}

double Parameters::SteelHeightStep_m() const {
  return steel_fit_ == SteelFit::kStrengthAndDepth ? tolerances_.steel_depth * Steel().height_base_m : 0.0;
}

double Parameters::CoilStrength(int coil) const {
  return 1 + tolerances_.coil_strength * x_.tail<kShared>()[kStrengthAt + coil];
}

Eigen::Matrix<double, 3, 2> Parameters::CoilTiltAxes(int coil) const {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(CoilAxis(coil));
  Eigen::Matrix<double, 3, 2> axes;
  axes << basis.e1, basis.e2;
  return axes;
}

Vector3d Parameters::CoilTilt(int coil) const {
  return tolerances_.coil_axis_rad * (CoilTiltAxes(coil) * x_.tail<kShared>().segment<2>(kTiltAt + 2 * coil));
}

std::string Parameters::Name(int index) const {
  if (index >= shared_at()) return kSharedLabels[index - shared_at()].name;
  const int of_sensor = index % kSensorUnknowns;
  const char axis[] = {"xyz"[of_sensor % 3], '\0'};
  return "sensor " + std::to_string(index / kSensorUnknowns) + " " + kSensorLabels[of_sensor / 3].name + " " + axis;
}

std::string Parameters::Unit(int index) const {
  if (index >= shared_at()) return kSharedLabels[index - shared_at()].unit;
  return kSensorLabels[index % kSensorUnknowns / 3].unit;
}

double Parameters::ToleranceInUnit(int index) const {
  if (index >= shared_at()) {
    const int at = index - shared_at();
    return kSharedLabels[at].scale * SharedTolerance(tolerances_, at);
  }
  const int kind = index % kSensorUnknowns / 3;
  return kSensorLabels[kind].scale * SensorTolerance(tolerances_, kind);
}

}  // namespace omni::calibration
