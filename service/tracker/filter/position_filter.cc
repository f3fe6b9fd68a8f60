#include "service/tracker/filter/position_filter.h"

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
constexpr double kRestartGate = 400;        // 20 standard deviations: not the same motion
constexpr double kLearnMax = 10;

Matrix3d Load(const std::array<double, 9>& values) { return Eigen::Map<const RowMajor3>(values.data()); }
void Store(const Matrix3d& matrix, std::array<double, 9>& values) { Eigen::Map<RowMajor3>(values.data()) = matrix; }
Matrix3d Symmetric(const Matrix3d& matrix) { return 0.5 * (matrix + matrix.transpose()); }

Matrix3d PositionCovariance(const PoseMeasurement& measured) {
  return Eigen::Map<const Eigen::Matrix<double, 5, 5, Eigen::RowMajor>>(measured.covariance.data())
      .topLeftCorner<3, 3>();
}

// sum <- sum + w (P + a b^T)
void AddWeighed(double weight, const std::array<double, 9>& covariance, const Vector3d& a, const Vector3d& b,
                std::array<double, 9>& sum) {
  Eigen::Map<Eigen::Array<double, 9, 1>>(sum.data()) +=
      weight * Eigen::Map<const Eigen::Array<double, 9, 1>>(covariance.data());
  const Vector3d scaled = weight * a;
  Eigen::Map<Matrix3d> columns(sum.data());  // of the transposed matrix
  columns.col(0) += scaled[0] * b;
  columns.col(1) += scaled[1] * b;
  columns.col(2) += scaled[2] * b;
}

// x = sum w_i x_i,   P = sum w_i (P_i + d_i d_i^T),   d_i = x_i - x
Motion MeanMotion(const std::array<Motion, kModels>& motions, const Likely& weights) {
  Motion mean;
  Vector3d p = Vector3d::Zero(), v = Vector3d::Zero();
  for (std::size_t i = 0; i < kModels; ++i) {
    p += weights[i] * base::ToEigen(motions[i].position_base_m);
    v += weights[i] * base::ToEigen(motions[i].velocity_base_m_s);
  }
  mean.position_base_m = base::FromEigen(p);
  mean.velocity_base_m_s = base::FromEigen(v);
  for (std::size_t i = 0; i < kModels; ++i) {
    const Vector3d dp = base::ToEigen(motions[i].position_base_m) - p;
    const Vector3d dv = base::ToEigen(motions[i].velocity_base_m_s) - v;
    AddWeighed(weights[i], motions[i].covariance_pp, dp, dp, mean.covariance_pp);
    AddWeighed(weights[i], motions[i].covariance_pv, dp, dv, mean.covariance_pv);
    AddWeighed(weights[i], motions[i].covariance_vv, dv, dv, mean.covariance_vv);
  }
  return mean;
}

void PublishMotion(FilterState& state) {
  static_cast<Motion&>(state) = MeanMotion(state.motions.estimate, state.motions.likely);
}

// p <- p,   v <- 0,   P_pp <- P_pp + R min(w dt / r, g),   r the largest variance in R: a wander that is slow against
// the noise in each direction, or the best known direction would decide the state
void Rest(const FilterNoise& noise, double dt_s, const std::array<double, 9>& white_m2, Motion& motion) {
  const double worst_m2 = std::max({white_m2[0], white_m2[4], white_m2[8]});
  const double share = worst_m2 > 0 ? std::min(noise.rest_wander_m2_s * dt_s / worst_m2, noise.rest_wander_share) : 0;
  motion.velocity_base_m_s = {};
  motion.covariance_pv = {};
  motion.covariance_vv = {};
  for (std::size_t i = 0; i < 9; ++i) motion.covariance_pp[i] += share * white_m2[i];
  for (std::size_t i = 0; i < 9; i += 4) motion.covariance_vv[i] = noise.rest_speed_m_s * noise.rest_speed_m_s;
}

// Q = q [dt^3/3, dt^2/2; dt^2/2, dt]   [Bar-Shalom, Li, Kirubarajan 2001, 6.2.2]
void Extrapolate(double q, double dt, Motion& motion) {
  motion.position_base_m =
      base::FromEigen(base::ToEigen(motion.position_base_m) + dt * base::ToEigen(motion.velocity_base_m_s));
  const Matrix3d pv = Load(motion.covariance_pv), vv = Load(motion.covariance_vv);
  const Matrix3d I = Matrix3d::Identity();
  Store(Load(motion.covariance_pp) + dt * (pv + pv.transpose()) + dt * dt * vv + q * dt * dt * dt / 3 * I,
        motion.covariance_pp);
  Store(pv + dt * vv + q * dt * dt / 2 * I, motion.covariance_pv);
  Store(vv + q * dt * I, motion.covariance_vv);
}

// Returns the log-likelihood of the measurement, with R_judged: the lasting part changes at once with a force's
// currents, and is no start of a motion. whitened: the innovation in its standard deviations.
double Correct(const Vector3d& measured_m, const Matrix3d& R, const Matrix3d& R_judged, Motion& motion,
               Vector3d* whitened) {
  const Vector3d innovation = measured_m - base::ToEigen(motion.position_base_m);
  const Matrix3d pp = Load(motion.covariance_pp), pv = Load(motion.covariance_pv), vv = Load(motion.covariance_vv);
  const Matrix3d S_inverse = (pp + R).inverse(), S_judged = pp + R_judged;
  const Matrix3d K_p = pp * S_inverse, K_v = pv.transpose() * S_inverse;
  motion.position_base_m = base::FromEigen(base::ToEigen(motion.position_base_m) + K_p * innovation);
  motion.velocity_base_m_s = base::FromEigen(base::ToEigen(motion.velocity_base_m_s) + K_v * innovation);
  Store(Symmetric(pp - K_p * pp), motion.covariance_pp);
  Store(pv - K_p * pv, motion.covariance_pv);
  Store(Symmetric(vv - K_v * pv), motion.covariance_vv);
  if (whitened != nullptr) *whitened = Eigen::LLT<Matrix3d>(S_inverse).matrixU() * innovation;
  return -0.5 * (innovation.dot(S_judged.inverse() * innovation) + std::log(S_judged.determinant()));
}

//   S R S,   S = a u u^T + b (I - u u^T),   u = p / |p|,   of the shares a^2 along u and b^2 across
std::array<double, 9> PartOf(const PoseMeasurement& measured, double share_along, double share_across) {
  const Vector3d u = base::ToEigen(measured.position_base_m).normalized();
  const double along = std::sqrt(share_along), across = std::sqrt(share_across);
  const Matrix3d S = across * Matrix3d::Identity() + (along - across) * u * u.transpose();
  std::array<double, 9> part;
  Store(Symmetric(S * PositionCovariance(measured) * S), part);
  return part;
}

void LearnPositionWhiteness(const FilterNoise& noise, const PoseMeasurement& measured, const Matrix3d& R, double dt_s,
                            Whiteness& whiteness) {
  const std::optional<Vector3d> third = ThirdDifference(measured.position_base_m, whiteness);
  if (!third) return;
  const Vector3d u = base::ToEigen(measured.position_base_m).normalized();
  const double along = third->dot(u), variance = u.dot(R * u);
  LearnShare(noise, along * along, variance, dt_s, whiteness.along);
  LearnShare(noise, third->squaredNorm() - along * along, R.trace() - variance, dt_s, whiteness.share);
}

}  // namespace

void LearnLiveliness(const FilterNoise& noise, const Vector3d& whitened, Liveliness& liveliness) noexcept {
  Eigen::Map<Vector3d> recent(liveliness.recent.data());
  const double step = noise.calm_rate * std::clamp(whitened.dot(recent), -kLearnMax, kLearnMax);
  liveliness.log_factor = std::clamp(liveliness.log_factor + step, noise.calm_log_min, noise.calm_log_max);
  recent += noise.calm_memory * (whitened - recent);
}

std::optional<Vector3d> ThirdDifference(const base::Vec3& measured, Whiteness& whiteness) noexcept {
  auto& last = whiteness.last;
  const Vector3d third =
      base::ToEigen(measured) - base::ToEigen(last[2]) + 3 * (base::ToEigen(last[1]) - base::ToEigen(last[0]));
  const bool known = whiteness.count == 3;
  last = {measured, last[0], last[1]};
  whiteness.count = std::min(whiteness.count + 1, 3);
  return known ? std::optional(third) : std::nullopt;
}

// White noise of variance s^2 makes third differences of 20 s^2: 1 + 9 + 9 + 1.
void LearnShare(const FilterNoise& noise, double third_squared, double variance, double dt_s, double& share) noexcept {
  if (!(variance > 0)) return;
  const double now = std::clamp(third_squared / (20 * variance), 0.0, kLearnMax);
  share = std::clamp(share + std::min(1.0, dt_s / noise.white_time_s) * (now - share), noise.white_min, 1.0);
}

void ResetMotion(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept {
  Motion motion;
  motion.position_base_m = measured.position_base_m;
  Store(PositionCovariance(measured), motion.covariance_pp);
  Store(kVelocitySigma_m_s * kVelocitySigma_m_s * Matrix3d::Identity(), motion.covariance_vv);
  state.motions.estimate.fill(motion);
  state.white_m2 = motion.covariance_pp;
  Rest(noise, 0, state.white_m2, state.motions.estimate[kAtRest]);
  state.motions.likely = noise.likely_at_first;
  PublishMotion(state);
}

void PredictMotion(const FilterNoise& noise, const TransitionRates& follows_1_s, double dt_s,
                   FilterState& state) noexcept {
  Interact(follows_1_s, dt_s, MeanMotion, state.motions);
  auto& now = state.motions.estimate;
  Rest(noise, dt_s, state.white_m2, now[kAtRest]);
  Extrapolate(noise.acceleration_m2_s3 * std::exp(state.position_liveliness.log_factor), dt_s, now[kConstantVelocity]);
  Extrapolate(noise.acceleration_m2_s3 * noise.manoeuvre_factor, dt_s, now[kManoeuvre]);
  PublishMotion(state);
}

bool CorrectMotion(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                   FilterState& state) noexcept {
  const Matrix3d R = PositionCovariance(measured);
  const Vector3d z = base::ToEigen(measured.position_base_m);
  LearnPositionWhiteness(noise, measured, R, dt_s, state.position_whiteness);
  const Motion& manoeuvre = state.motions.estimate[kManoeuvre];
  const Vector3d innovation = z - base::ToEigen(manoeuvre.position_base_m);
  const Matrix3d S = Load(manoeuvre.covariance_pp) + R;
  if (!(innovation.dot(S.inverse() * innovation) <= kRestartGate)) return false;
  const Whiteness& whiteness = state.position_whiteness;
  state.white_m2 = PartOf(measured, whiteness.along, whiteness.share);
  const std::array<double, 9> lasting_m2 = PartOf(measured, 1 - whiteness.along, 1 - whiteness.share);
  const double step = std::min(1.0, dt_s / noise.lasting_s);
  for (std::size_t i = 0; i < 9; ++i) state.lasting_m2[i] += step * (lasting_m2[i] - state.lasting_m2[i]);
  const Matrix3d R_white = Load(state.white_m2);
  Vector3d whitened;
  CorrectEach(
      [&](std::size_t model, Motion& motion) {
        return Correct(z, R_white, R, motion, model == kConstantVelocity ? &whitened : nullptr);
      },
      state.motions);
  LearnLiveliness(noise, whitened, state.position_liveliness);
  PublishMotion(state);
  return true;
}

}  // namespace omni::tracker
