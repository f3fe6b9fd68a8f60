#include "service/tracker/filter.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kVelocitySigma_m_s = 0.3;  // of a hand whose motion is not known yet
constexpr double kRateSigma_rad_s = 3;
constexpr double kManoeuvreGate = 16.3;  // chi2 of 3 degrees of freedom exceeds it once in 1,000 scans
constexpr double kRestartGate = 400;     // 20 standard deviations: not this motion
constexpr double kLearnMax = 10;
constexpr double kManoeuvreGate2 = 13.8;  // the same for 2 degrees of freedom

Matrix3d Load(const std::array<double, 9>& values) { return Eigen::Map<const RowMajor3>(values.data()); }
void Store(const Matrix3d& matrix, std::array<double, 9>& values) { Eigen::Map<RowMajor3>(values.data()) = matrix; }
Matrix3d Symmetric(const Matrix3d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

// Q = q [dt^3/3, dt^2/2; dt^2/2, dt]   [Bar-Shalom, Li, Kirubarajan 2001, 6.2.2]
void AddAcceleration(double q, double dt, FilterState& state) {
  for (std::size_t i = 0; i < 9; i += 4) {
    state.covariance_pp[i] += q * dt * dt * dt / 3;
    state.covariance_pv[i] += q * dt * dt / 2;
    state.covariance_vv[i] += q * dt;
  }
}

void AddAngularAcceleration(double q, double dt, FilterState& state) {
  state.variance_angle += q * dt * dt * dt / 3;
  state.covariance_angle_rate += q * dt * dt / 2;
  state.variance_rate += q * dt;
}

// A filter whose q is right has white innovations [Mehra 1970]: `whitened` . `recent` is zero on the average; positive
// means that the filter lags behind.
void Learn(const FilterNoise& noise, const Vector3d& whitened, Liveliness& liveliness) {
  Eigen::Map<Vector3d> recent(liveliness.recent.data());
  const double step = noise.calm_rate * std::clamp(whitened.dot(recent), -kLearnMax, kLearnMax);
  liveliness.log_factor = std::clamp(liveliness.log_factor + step, noise.calm_log_min, noise.calm_log_max);
  recent += noise.calm_memory * (whitened - recent);
}

// White noise of variance s^2 in each of n directions makes third differences of 20 n s^2: 1 + 9 + 9 + 1.
void LearnWhiteness(const FilterNoise& noise, const base::Vec3& measured, double variance, double directions, double dt,
                    Whiteness& whiteness) {
  auto& last = whiteness.last;
  if (whiteness.count == 3 && variance > 0) {
    const Vector3d third =
        base::ToEigen(measured) - base::ToEigen(last[2]) + 3 * (base::ToEigen(last[1]) - base::ToEigen(last[0]));
    const double share = std::clamp(third.squaredNorm() / (20 * directions * variance), 0.0, kLearnMax);
    whiteness.share += std::min(1.0, dt / noise.white_time_s) * (share - whiteness.share);
    whiteness.share = std::clamp(whiteness.share, noise.white_min, 1.0);
  }
  last = {measured, last[0], last[1]};
  whiteness.count = std::min(whiteness.count + 1, 3);
}

double AngleVariance(const PoseMeasurement& measured) {
  return 0.5 * (measured.covariance[18] + measured.covariance[24]);
}

Matrix3d PositionCovariance(const PoseMeasurement& measured) {
  return Eigen::Map<const Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(measured.covariance.data())
      .topLeftCorner<3, 3>();
}

// A mean with memory m over residuals of variance R has variance R m / (2 - m).
void WatchLag(const FilterNoise& noise, const Vector3d& ahead_m, const Matrix3d& R_white, FilterState& state) {
  const Vector3d lag_m = base::ToEigen(state.lag_m) + noise.lag_memory * (ahead_m - base::ToEigen(state.lag_m));
  state.lag_m = base::FromEigen(lag_m);
  state.lags = lag_m.dot(R_white.inverse() * lag_m) > kManoeuvreGate * noise.lag_memory / (2 - noise.lag_memory);
}

// False: the measured position cannot follow from the prediction.
bool CorrectPosition(const FilterNoise& noise, const PoseMeasurement& measured, double dt, FilterState& state) {
  const Matrix3d R = PositionCovariance(measured);
  LearnWhiteness(noise, measured.position_base_m, R.trace() / 3, 3, dt, state.position_whiteness);
  const Vector3d innovation = base::ToEigen(measured.position_base_m) - base::ToEigen(state.position_base_m);
  Matrix3d S_inverse = (Load(state.covariance_pp) + R).inverse();
  if (innovation.dot(S_inverse * innovation) > kManoeuvreGate) {
    AddAcceleration(noise.acceleration_m2_s3 * noise.manoeuvre_factor, dt, state);
    state.position_liveliness.log_factor = std::max(state.position_liveliness.log_factor, 0.0);
    S_inverse = (Load(state.covariance_pp) + R).inverse();
    if (!(innovation.dot(S_inverse * innovation) <= kRestartGate)) return false;
  }
  const Matrix3d R_white = state.position_whiteness.share * R;
  S_inverse = (Load(state.covariance_pp) + R_white).inverse();
  const Eigen::LLT<Matrix3d> root(S_inverse);
  Learn(noise, root.matrixU() * innovation, state.position_liveliness);
  const Matrix3d pp = Load(state.covariance_pp), pv = Load(state.covariance_pv), vv = Load(state.covariance_vv);
  const Matrix3d K_p = pp * S_inverse;
  const Matrix3d K_v = pv.transpose() * S_inverse;
  state.position_base_m = base::FromEigen(base::ToEigen(state.position_base_m) + K_p * innovation);
  state.velocity_base_m_s = base::FromEigen(base::ToEigen(state.velocity_base_m_s) + K_v * innovation);
  Store(Symmetric(pp - K_p * pp), state.covariance_pp);
  Store(pv - K_p * pv, state.covariance_pv);
  Store(Symmetric(vv - K_v * pv), state.covariance_vv);
  WatchLag(noise, innovation - K_p * innovation, R_white, state);
  return true;
}

// Innovation: the rotation vector from the predicted to the measured axis, perpendicular to both.
void CorrectAxis(const FilterNoise& noise, const PoseMeasurement& measured, double dt, FilterState& state) {
  const Vector3d u = base::ToEigen(state.axis_base);
  const Vector3d z = base::ToEigen(measured.axis_base);
  const Vector3d cross = u.cross(z);
  const double sine = cross.norm();
  const double angle = std::atan2(sine, u.dot(z));
  const Vector3d innovation = sine > 1e-12 ? Vector3d(angle / sine * cross) : Vector3d(cross);
  const double R = AngleVariance(measured);
  LearnWhiteness(noise, measured.axis_base, R, 2, dt, state.axis_whiteness);
  if (angle * angle > kManoeuvreGate2 * (state.variance_angle + R)) {
    AddAngularAcceleration(noise.angular_acceleration_rad2_s3 * noise.manoeuvre_factor, dt, state);
    state.axis_liveliness.log_factor = std::max(state.axis_liveliness.log_factor, 0.0);
  }
  const double S = state.variance_angle + state.axis_whiteness.share * R;
  Learn(noise, innovation / std::sqrt(S), state.axis_liveliness);
  const double K_angle = state.variance_angle / S;
  const double K_rate = state.covariance_angle_rate / S;
  state.axis_base = TurnAxis(state.axis_base, base::FromEigen(K_angle * innovation));
  const Vector3d turned = base::ToEigen(state.axis_base);
  const Vector3d rate = base::ToEigen(state.angular_velocity_base_rad_s) + K_rate * innovation;
  state.angular_velocity_base_rad_s = base::FromEigen(rate - turned.dot(rate) * turned);
  state.variance_rate -= K_rate * state.covariance_angle_rate;
  state.covariance_angle_rate -= K_angle * state.covariance_angle_rate;
  state.variance_angle -= K_angle * state.variance_angle;
}

}  // namespace

// [Rodrigues] for a turn perpendicular to u: u cos|t| + (t x u) sin|t|/|t|; renormalised against drift.
base::Vec3 TurnAxis(const base::Vec3& axis, const base::Vec3& turn_rad) noexcept {
  const Vector3d u = base::ToEigen(axis);
  const Vector3d t = base::ToEigen(turn_rad);
  const double angle = t.norm();
  const double sinc = angle > 1e-8 ? std::sin(angle) / angle : 1.0;
  return base::FromEigen((std::cos(angle) * u + sinc * t.cross(u)).normalized());
}

void ResetFilter(const PoseMeasurement& measured, FilterState& state) noexcept {
  state = FilterState{};
  state.position_base_m = measured.position_base_m;
  state.axis_base = measured.axis_base;
  Store(PositionCovariance(measured), state.covariance_pp);
  Store(kVelocitySigma_m_s * kVelocitySigma_m_s * Matrix3d::Identity(), state.covariance_vv);
  state.variance_angle = AngleVariance(measured);
  state.variance_rate = kRateSigma_rad_s * kRateSigma_rad_s;
}

void PredictFilter(const FilterNoise& noise, double dt_s, FilterState& state) noexcept {
  const Vector3d v = base::ToEigen(state.velocity_base_m_s);
  const Vector3d w = base::ToEigen(state.angular_velocity_base_rad_s);
  state.position_base_m = base::FromEigen(base::ToEigen(state.position_base_m) + dt_s * v);
  state.axis_base = TurnAxis(state.axis_base, base::FromEigen(dt_s * w));
  const Matrix3d pp = Load(state.covariance_pp), pv = Load(state.covariance_pv), vv = Load(state.covariance_vv);
  Store(pp + dt_s * (pv + pv.transpose()) + dt_s * dt_s * vv, state.covariance_pp);
  Store(pv + dt_s * vv, state.covariance_pv);
  state.variance_angle += dt_s * (2 * state.covariance_angle_rate + dt_s * state.variance_rate);
  state.covariance_angle_rate += dt_s * state.variance_rate;
  AddAcceleration(noise.acceleration_m2_s3 * std::exp(state.position_liveliness.log_factor), dt_s, state);
  AddAngularAcceleration(noise.angular_acceleration_rad2_s3 * std::exp(state.axis_liveliness.log_factor), dt_s, state);
}

void CorrectFilter(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                   FilterState& state) noexcept {
  if (!CorrectPosition(noise, measured, dt_s, state)) return ResetFilter(measured, state);
  CorrectAxis(noise, measured, dt_s, state);
}

}  // namespace omni::tracker
