#include "service/calibration/fit/system.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/calibration/fit/residual.h"
#include "service/calibration/fit/tool_field.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/zonal.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// One sensor's share of the array block: its own unknowns, then the shared ones.
struct LocalSums {
  Eigen::Matrix<double, kLocal, kLocal> H = Eigen::Matrix<double, kLocal, kLocal>::Zero();
  Eigen::Matrix<double, kLocal, 1> g = Eigen::Matrix<double, kLocal, 1>::Zero();
  SensorFit fit;
};

// The touches' share for the shared unknowns.
struct SharedSums {
  Eigen::Matrix<double, kSampleShared, kSampleShared> H = Eigen::Matrix<double, kSampleShared, kSampleShared>::Zero();
  Eigen::Matrix<double, kSampleShared, 1> g = Eigen::Matrix<double, kSampleShared, 1>::Zero();
};

void Count(const Vector3d& residual_T, const Vector3d& inverse_sigma, double weight, SensorFit& fit) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(inverse_sigma[axis] > 0)) continue;
    const double whitened = inverse_sigma[axis] * residual_T[axis];
    fit.chi2 += weight * whitened * whitened;
    fit.square_T2 += weight * residual_T[axis] * residual_T[axis];
    fit.readings += weight;
  }
}

void AddTouch(const Parameters& parameters, const ToolFrame& frame, double weight, double sigma_m, SampleBlock& block,
              SharedSums& shared) {
  const TouchResidual touch = CompareTouch(parameters, frame);
  const double r = touch.gap_m / sigma_m;
  const Eigen::Matrix<double, 5, 1> J = touch.by_pose.transpose() / sigma_m;
  const Eigen::Matrix<double, kSampleShared, 1> S = touch.by_shared.transpose() / sigma_m;
  block.touch_chi2 = r * r;
  block.cost += weight * r * r;
  block.H.topLeftCorner<5, 5>() += weight * J * J.transpose();
  block.g.head<5>() += weight * r * J;
  block.C.block<5, kSampleShared>(0, parameters.shared_at()) += weight * J * S.transpose();
  shared.H += weight * S * S.transpose();
  shared.g += weight * r * S;
}

SampleBlock AddSample(const Parameters& parameters, const ArrayState& array, const Observation& observation,
                      const Instant& instant, double touch_sigma_m, std::vector<LocalSums>& sums, SharedSums& touches) {
  const ToolFrame frame = MakeToolFrame(instant.position_base_m, instant.axis_base);
  const int shared_at = parameters.shared_at();
  SampleBlock block;
  block.H.setZero();
  block.g.setZero();
  block.C.setZero(kOwn, parameters.size());
  // The remanence has its tolerance as prior.
  block.H.diagonal().tail<3>().setOnes();
  block.g.tail<3>() = instant.remanence;
  block.cost = instant.remanence.squaredNorm();
  const double root_weight = std::sqrt(observation.weight);
  for (std::size_t i = 0; i < array.sensors.size(); ++i) {
    const Residual residual = ComputeResidual(parameters, array, i, observation.tau, frame, instant.remanence,
                                              observation.kept, observation.tool_sensor_T[i]);
    const Vector3d scale = root_weight * observation.inverse_sigma[i];
    const Vector3d r = scale.cwiseProduct(residual.r);
    const Eigen::Matrix<double, 3, kOwn> own = scale.asDiagonal() * residual.own;
    const LocalJacobian J = scale.asDiagonal() * residual.array;
    block.chi2 += observation.inverse_sigma[i].cwiseProduct(residual.r).squaredNorm();
    block.cost += r.squaredNorm();
    block.H += own.transpose() * own;
    block.g += own.transpose() * r;
    block.C.middleCols<kSensorUnknowns>(kSensorUnknowns * static_cast<int>(i)) =
        own.transpose() * J.leftCols<kSensorUnknowns>();
    block.C.middleCols<kSampleShared>(shared_at) += own.transpose() * J.rightCols<kSampleShared>();
    sums[i].H += J.transpose() * J;
    sums[i].g += J.transpose() * r;
    Count(residual.r, observation.inverse_sigma[i], observation.weight, sums[i].fit);
  }
  if (observation.touches_hull) {
    AddTouch(parameters, frame, observation.touch_weight, touch_sigma_m, block, touches);
  }
  return block;
}

void Scatter(const std::vector<LocalSums>& sums, int shared_at, System& system) {
  constexpr int n = kSensorUnknowns, s = kSampleShared;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const int at = n * static_cast<int>(i);
    const auto& H = sums[i].H;
    system.H.block<n, n>(at, at) += H.topLeftCorner<n, n>();
    system.H.block<n, s>(at, shared_at) += H.topRightCorner<n, s>();
    system.H.block<s, n>(shared_at, at) += H.bottomLeftCorner<s, n>();
    system.H.block<s, s>(shared_at, shared_at) += H.bottomRightCorner<s, s>();
    system.g.segment<n>(at) += sums[i].g.head<n>();
    system.g.segment<s>(shared_at) += sums[i].g.tail<s>();
    system.sensors.push_back(sums[i].fit);
  }
}

// An axis that is missing or saturated has no weight.
void PrepareSensor(const base::SensorCalibration& sensor, const Sample& sample, std::size_t i,
                   const base::Calibration& nominal, double model_error, Observation& observation) {
  const Vector3d read = base::ToEigen(sample.field_sensor_T[i]);
  const Eigen::Map<const RowMajor3d> map(sensor.current_map_T_A.data());
  const Vector3d coils = map * Eigen::Map<const Vector3d>(sample.coil_current_A.data());
  const Vector3d y = read - base::ToEigen(sensor.background_sensor_T) - coils;
  Vector3d known = Vector3d::Zero(), inverse = Vector3d::Zero();
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) square += std::isfinite(y[axis]) ? y[axis] * y[axis] : 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(y[axis])) continue;
    const double noise = sample.noise_scale * nominal.sensor_noise_T[static_cast<std::size_t>(axis)];
    known[axis] = y[axis];
    inverse[axis] = 1 / std::sqrt(noise * noise + model_error * model_error * square);
    ++observation.readings;
  }
  observation.tool_sensor_T.push_back(known);
  observation.inverse_sigma.push_back(inverse);
}

}  // namespace

Instant MovedInstant(const Instant& instant, const OwnVector& step) {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(instant.axis_base);
  return {instant.position_base_m + step.head<3>(),
          (instant.axis_base + step[3] * basis.e1 + step[4] * basis.e2).normalized(),
          instant.remanence + step.tail<3>()};
}

Problem::Problem(const base::Calibration& nominal, std::span<const base::CoilGeometry> coils,
                 const Recording& recording, const Tolerances& tolerances)
    : nominal_(nominal), touch_sigma_m_(tolerances.touch_m), remanence_A_(tolerances.remanence_A) {
  if (!coils.empty()) core_current_A_T_ = magnetics::CoreCurrents(nominal_);
  for (std::size_t i = 0; i < recording.responses.size(); ++i) {
    const CoilResponse& response = recording.responses[i];
    nominal_.sensors[i].background_sensor_T = response.background_sensor_T;
    nominal_.sensors[i].current_map_T_A = response.map_sensor_T_A;
    map_error_T_A_.push_back(response.map_error_T_A);
  }
  for (std::size_t k = 0; !recording.responses.empty() && k < coils.size(); ++k) {
    const auto winding = magnetics::MakeWinding(coils[k], static_cast<int>(k));
    coil_moments_.push_back({magnetics::WindingMoments(winding),
                             magnetics::CoreMoments(winding, nominal.core_radius_m, nominal.core_kappa)});
  }
  double first_s = 0, last_s = 0;
  if (!recording.samples.empty()) {
    const auto [first, last] = std::minmax_element(recording.samples.begin(), recording.samples.end(),
                                                   [](const Sample& a, const Sample& b) { return a.t_s < b.t_s; });
    first_s = first->t_s, last_s = last->t_s;
  }
  for (const Sample& sample : recording.samples) {
    Observation observation;
    observation.t_s = sample.t_s;
    observation.tau = last_s > first_s ? 2 * (sample.t_s - first_s) / (last_s - first_s) - 1 : 0.0;
    observation.touches_hull = sample.touches_hull && nominal.hull_radius_m > 0;
    for (std::size_t i = 0; i < nominal_.sensors.size(); ++i) {
      PrepareSensor(nominal_.sensors[i], sample, i, nominal_, tolerances.model_error_relative, observation);
    }
    observations_.push_back(std::move(observation));
  }
}

// Every unknown of the array is 0 with variance 1, and the mean gain is 1. (2.1), (3.1)
void Problem::AddPriors(const Parameters& parameters, System& system) const {
  system.H.diagonal().array() += 1;
  system.g += parameters.x();
  system.cost += parameters.x().squaredNorm();
  const Eigen::VectorXd v = GainScaleDirection(parameters);
  const double scale = v.dot(parameters.x());
  system.H += kGaugeWeight * v * v.transpose();
  system.g += (kGaugeWeight * scale) * v;
  system.cost += kGaugeWeight * scale * scale;
}

namespace {

constexpr int kCoilUnknowns = 5;  // tilt (2), the core's centre (3)

// Of one coil at a place that is measured from the core: the windings are about the hull's centre; what they induce in
// the core is about the core's, since a winding's field has no gradient in its middle. (3.2)
struct CoilAt {
  const magnetics::CoilMoments& winding;
  const magnetics::CoilMoments& core;
  Vector3d axis;
  Eigen::Matrix<double, 3, 2> tilt_axes;
  Vector3d centre_m;  // of the core

  PlacedField<kCoilUnknowns> operator()(const Vector3d& place_m) const {
    const Vector3d from_winding = place_m + centre_m;
    const Matrix3d of_winding = magnetics::ZonalGradient(winding, axis, from_winding);
    const Matrix3d by_axis = magnetics::ZonalAxisDerivative(winding, axis, from_winding) +
                             magnetics::ZonalAxisDerivative(core, axis, place_m);
    PlacedField<kCoilUnknowns> field;
    field.B = magnetics::ZonalField(winding, axis, from_winding) + magnetics::ZonalField(core, axis, place_m);
    for (int j = 0; j < 2; ++j) field.by.col(j) = by_axis * tilt_axes.col(j).cross(axis);
    field.by.rightCols<3>() = of_winding;
    field.by_place = of_winding + magnetics::ZonalGradient(core, axis, place_m);
    return field;
  }
};

}  // namespace

// A measured map against the coil's shape at the sensor: strength E N B_k(s; axis), B_k with the steel's response.
// (3.2)
void Problem::AddMaps(const Parameters& parameters, System& system) const {
  constexpr int n = kSensorUnknowns, all = n + 1 + kCoilUnknowns + 2;
  const Tolerances& t = parameters.tolerances();
  const int shared_at = parameters.shared_at();
  const base::SteelPlane steel = parameters.Steel();
  for (int k = 0; k < static_cast<int>(coil_moments_.size()); ++k) {
    const auto& [winding, core] = coil_moments_[static_cast<std::size_t>(k)];
    const double strength = parameters.CoilStrength(k);
    const Vector3d axis = (parameters.CoilAxis(k) + parameters.CoilTilt(k).cross(parameters.CoilAxis(k))).normalized();
    const CoilAt coil_at{winding, core, axis, parameters.CoilTiltAxes(k), parameters.CoreCentre_m()};
    const PlacedField<kCoilUnknowns> centre = coil_at(MirroredPlace(steel.height_base_m, Vector3d::Zero()));
    for (int i = 0; i < parameters.sensors(); ++i) {
      const SensorState sensor = parameters.Sensor(i);
      const Vector3d& s = sensor.position_base_m;
      const SteelResponse<kCoilUnknowns> answer = SteelResponseOf(
          s, nominal_.core_radius_m, parameters.Kappa(), coil_at(MirroredPlace(steel.height_base_m, s)), centre);
      PlacedField<kCoilUnknowns> field = coil_at(s);
      field.B += steel.strength * answer.field.B;
      field.by += steel.strength * answer.field.by;
      field.by_place += steel.strength * answer.field.by_place;
      const auto& map = nominal_.sensors[static_cast<std::size_t>(i)].current_map_T_A;
      const Vector3d measured = Eigen::Map<const RowMajor3d>(map.data()).col(k);
      const double sigma = std::hypot(map_error_T_A_[static_cast<std::size_t>(i)], t.coil_shape * measured.norm());
      const Vector3d r = (strength * (sensor.gain * field.B) - measured) / sigma;
      Eigen::Matrix<double, 3, all> J;
      J.middleCols<3>(kPositionAt) = (strength * t.sensor_position_m) * sensor.gain * field.by_place;
      J.middleCols<9>(kGainAt) = parameters.GainJacobian(strength * (sensor.nominal * field.B));
      J.col(n) = t.coil_strength * (sensor.gain * field.B);
      J.middleCols<2>(n + 1) = (strength * t.coil_axis_rad) * sensor.gain * field.by.leftCols<2>();
      J.middleCols<3>(n + 3) = (strength * t.core_centre_m) * sensor.gain * field.by.rightCols<3>();
      J.col(n + 6) = (strength * parameters.SteelStrengthStep()) * (sensor.gain * answer.field.B);
      J.col(n + 7) = (strength * steel.strength * parameters.SteelHeightStep_m()) * (sensor.gain * answer.by_height);
      J /= sigma;
      const Eigen::Matrix<double, all, all> H = J.transpose() * J;
      const Eigen::Matrix<double, all, 1> g = J.transpose() * r;
      std::array<int, all> at{};
      for (int e = 0; e < n; ++e) at[static_cast<std::size_t>(e)] = n * i + e;
      at[n] = shared_at + kStrengthAt + k;
      at[n + 1] = shared_at + kTiltAt + 2 * k;
      at[n + 2] = at[n + 1] + 1;
      for (std::size_t e = 0; e < 3; ++e) at[n + 3 + e] = shared_at + kCentreAt + static_cast<int>(e);
      at[n + 6] = shared_at + kSteelAt;
      at[n + 7] = shared_at + kSteelDepthAt;
      for (int a = 0; a < all; ++a) {
        system.g[at[static_cast<std::size_t>(a)]] += g[a];
        for (int b = 0; b < all; ++b)
          system.H(at[static_cast<std::size_t>(a)], at[static_cast<std::size_t>(b)]) += H(a, b);
      }
      system.map_chi2 += r.squaredNorm();
      system.map_readings += 3;
    }
  }
  system.cost += system.map_chi2;
}

namespace {

constexpr double kUnbroken_s = 0.06;                   // from window to window: the path between them is known
constexpr int kWayParts = 16;                          // of the path from one to the next
constexpr double kKeptMin_A = 5e-3, kKeptMax_A = 0.1;  // that a core may keep, while it is being determined
constexpr double kTurned_A = 0.02;                     // change of the core's moment that reverses its remanence

// From b to c, share s of the path that goes through a, b, c, d [Catmull, Rom 1974].
Vector3d OnTheWay(const std::array<Vector3d, 4>& p, double s) {
  const Vector3d at_b = 0.5 * (p[2] - p[0]), at_c = 0.5 * (p[3] - p[1]), whole = p[2] - p[1];
  return p[1] + s * (at_b + s * (3 * whole - 2 * at_b - at_c + s * (at_b + at_c - 2 * whole)));
}

struct Way {
  std::vector<double> t_s;
  std::vector<Vector3d> moment_A;
};

bool IsJoined(const Way& way, std::size_t k) {
  return k + 1 < way.t_s.size() && way.t_s[k + 1] - way.t_s[k] <= kUnbroken_s;
}

// A point dragged along the path on a string, from the path to it. Over a gap only its ends are known.
std::vector<Vector3d> DrawnBehind(const Way& way, double string_A) {
  std::vector<Vector3d> behind_A;
  Vector3d stone_A = way.moment_A.empty() ? Vector3d(Vector3d::Zero()) : way.moment_A.front();
  for (std::size_t k = 0; k < way.moment_A.size(); ++k) {
    const Vector3d& from = way.moment_A[k];
    behind_A.push_back(stone_A - from);
    if (k + 1 == way.moment_A.size()) break;
    const Vector3d& to = way.moment_A[k + 1];
    const bool known = IsJoined(way, k);
    const Vector3d before = known && k > 0 && IsJoined(way, k - 1) ? way.moment_A[k - 1] : Vector3d(2 * from - to);
    const Vector3d after = known && IsJoined(way, k + 1) ? way.moment_A[k + 2] : Vector3d(2 * to - from);
    for (int part = 1; part <= kWayParts; ++part) {
      const Vector3d at = OnTheWay({before, from, to, after}, static_cast<double>(part) / kWayParts);
      const Vector3d string = stone_A - at;
      stone_A = at + string * std::min(1.0, string_A / std::max(string.norm(), string_A));
    }
  }
  return behind_A;
}

}  // namespace

Vector3d Problem::CoreCurrents_A(const Instant& instant) const {
  return core_current_A_T_ * magnetics::DipoleField(nominal_.moment_Am2 * instant.axis_base, instant.position_base_m);
}

// The core's remanence is dragged behind its moment like a stone on a string whose length is the greatest remanence.
// (1.2)
void Problem::FollowCore(const Parameters& parameters, std::span<const Instant> instants) {
  if (!follows_core()) return;
  Way way;
  std::vector<std::size_t> moving;
  for (std::size_t n = 0; n < observations_.size(); ++n) {
    const Vector3d now_A = CoreCurrents_A(instants[n]);
    if (observations_[n].touches_hull) {
      observations_[n].kept.col(1) = -now_A / (now_A.norm() + kTurned_A);
      continue;
    }
    moving.push_back(n);
    way.t_s.push_back(observations_[n].t_s);
    way.moment_A.push_back(now_A);
  }
  const double string_A = std::clamp(parameters.Kept_A(), kKeptMin_A, kKeptMax_A);
  const std::vector<Vector3d> behind_A = DrawnBehind(way, string_A);
  for (std::size_t k = 0; k < moving.size(); ++k) observations_[moving[k]].kept.col(0) = behind_A[k] / string_A;
}

System Problem::Linearise(const Parameters& parameters, std::span<const Instant> instants) const {
  const ArrayState array = MakeArrayState(parameters, nominal_, remanence_A_);
  System system;
  system.H.setZero(parameters.size(), parameters.size());
  system.g.setZero(parameters.size());
  std::vector<LocalSums> sums(array.sensors.size());
  SharedSums touches;
  system.samples.reserve(observations_.size());
  for (std::size_t n = 0; n < observations_.size(); ++n) {
    system.samples.push_back(
        AddSample(parameters, array, observations_[n], instants[n], touch_sigma_m_, sums, touches));
    system.cost += system.samples.back().cost;
  }
  Scatter(sums, parameters.shared_at(), system);
  system.H.block<kSampleShared, kSampleShared>(parameters.shared_at(), parameters.shared_at()) += touches.H;
  system.g.segment<kSampleShared>(parameters.shared_at()) += touches.g;
  AddPriors(parameters, system);
  AddMaps(parameters, system);
  return system;
}

Eigen::VectorXd GainScaleDirection(const Parameters& parameters) {
  Eigen::VectorXd v = Eigen::VectorXd::Zero(parameters.size());
  for (int i = 0; i < parameters.sensors(); ++i) v.segment<3>(kSensorUnknowns * i + kGainAt).setOnes();
  return v.normalized();
}

}  // namespace omni::calibration
