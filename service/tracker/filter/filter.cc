#include "service/tracker/filter/filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "service/base/eigen.h"
#include "service/tracker/filter/position_filter.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

constexpr double kRateSigma_rad_s = 3;  // of a hand whose motion is not known yet

double AngleVariance(const PoseMeasurement& measured) {
  return 0.5 * (measured.covariance[18] + measured.covariance[24]);
}

// The rotation vector from u to z, perpendicular to both.
Vector3d TurnBetween(const Vector3d& u, const Vector3d& z) {
  const Vector3d cross = u.cross(z);
  const double sine = cross.norm();
  return sine > 1e-12 ? Vector3d(std::atan2(sine, u.dot(z)) / sine * cross) : cross;
}

// As for the position, in the tangents of the mean axis; of each, half of a deviation's square.
Turning MeanTurning(const std::array<Turning, kModels>& turnings, const Likely& weights) {
  Vector3d sum = Vector3d::Zero(), rate = Vector3d::Zero();
  for (std::size_t i = 0; i < kModels; ++i) {
    sum += weights[i] * base::ToEigen(turnings[i].axis_base);
    rate += weights[i] * base::ToEigen(turnings[i].angular_velocity_base_rad_s);
  }
  const Vector3d u = sum.normalized();
  rate -= u.dot(rate) * u;
  Turning mean;
  mean.axis_base = base::FromEigen(u);
  mean.angular_velocity_base_rad_s = base::FromEigen(rate);
  for (std::size_t i = 0; i < kModels; ++i) {
    const Vector3d d = u.cross(base::ToEigen(turnings[i].axis_base));
    const Vector3d d_rate = base::ToEigen(turnings[i].angular_velocity_base_rad_s) - rate;
    mean.variance_angle += weights[i] * (turnings[i].variance_angle + 0.5 * d.squaredNorm());
    mean.covariance_angle_rate += weights[i] * (turnings[i].covariance_angle_rate + 0.5 * d.dot(d_rate));
    mean.variance_rate += weights[i] * (turnings[i].variance_rate + 0.5 * d_rate.squaredNorm());
  }
  return mean;
}

void PublishTurning(FilterState& state) {
  static_cast<Turning&>(state) = MeanTurning(state.turnings.estimate, state.turnings.likely);
}

void Rest(const FilterNoise& noise, double dt_s, Turning& turning) {
  turning.angular_velocity_base_rad_s = {};
  turning.variance_angle += noise.rest_wander_rad2_s * dt_s;
  turning.covariance_angle_rate = 0;
  turning.variance_rate = noise.rest_rate_rad_s * noise.rest_rate_rad_s;
}

void Extrapolate(double q, double dt, Turning& turning) {
  const Vector3d turn_rad = dt * base::ToEigen(turning.angular_velocity_base_rad_s);
  turning.axis_base = TurnAxis(turning.axis_base, base::FromEigen(turn_rad));
  turning.variance_angle +=
      dt * (2 * turning.covariance_angle_rate + dt * turning.variance_rate) + q * dt * dt * dt / 3;
  turning.covariance_angle_rate += dt * turning.variance_rate + q * dt * dt / 2;
  turning.variance_rate += q * dt;
}

double Correct(const Vector3d& measured, double R, double R_judged, Turning& turning, Vector3d* whitened) {
  const Vector3d innovation = TurnBetween(base::ToEigen(turning.axis_base), measured);
  const double S = turning.variance_angle + R, S_judged = turning.variance_angle + R_judged;
  const double K_angle = turning.variance_angle / S, K_rate = turning.covariance_angle_rate / S;
  turning.axis_base = TurnAxis(turning.axis_base, base::FromEigen(K_angle * innovation));
  const Vector3d turned = base::ToEigen(turning.axis_base);
  const Vector3d rate = base::ToEigen(turning.angular_velocity_base_rad_s) + K_rate * innovation;
  turning.angular_velocity_base_rad_s = base::FromEigen(rate - turned.dot(rate) * turned);
  turning.variance_rate -= K_rate * turning.covariance_angle_rate;
  turning.covariance_angle_rate -= K_angle * turning.covariance_angle_rate;
  turning.variance_angle -= K_angle * turning.variance_angle;
  if (whitened != nullptr) *whitened = innovation / std::sqrt(S);
  return -0.5 * innovation.squaredNorm() / S_judged - std::log(S_judged);
}

void ResetTurning(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept {
  Turning turning;
  turning.axis_base = measured.axis_base;
  turning.variance_angle = AngleVariance(measured);
  turning.variance_rate = kRateSigma_rad_s * kRateSigma_rad_s;
  state.turnings.estimate.fill(turning);
  Rest(noise, 0, state.turnings.estimate[kAtRest]);
  state.turnings.likely = noise.likely_at_first;
  PublishTurning(state);
}

void PredictTurning(const FilterNoise& noise, const TransitionRates& follows_1_s, double dt_s,
                    FilterState& state) noexcept {
  Interact(follows_1_s, dt_s, MeanTurning, state.turnings);
  auto& now = state.turnings.estimate;
  Rest(noise, dt_s, now[kAtRest]);
  Extrapolate(noise.angular_acceleration_rad2_s3 * std::exp(state.axis_liveliness.log_factor), dt_s,
              now[kConstantVelocity]);
  Extrapolate(noise.angular_acceleration_rad2_s3 * noise.manoeuvre_factor, dt_s, now[kManoeuvre]);
  PublishTurning(state);
}

void CorrectTurning(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                    FilterState& state) noexcept {
  const double R = AngleVariance(measured);
  const Vector3d z = base::ToEigen(measured.axis_base);
  if (const auto third = ThirdDifference(measured.axis_base, state.axis_whiteness)) {
    LearnShare(noise, third->squaredNorm(), 2 * R, dt_s, state.axis_whiteness.share);
  }
  const double R_white = state.axis_whiteness.share * R;
  state.lasting_rad2 += std::min(1.0, dt_s / noise.lasting_s) * (R - R_white - state.lasting_rad2);
  Vector3d whitened;
  CorrectEach(
      [&](std::size_t model, Turning& turning) {
        return Correct(z, R_white, R, turning, model == kConstantVelocity ? &whitened : nullptr);
      },
      state.turnings);
  LearnLiveliness(noise, whitened, state.axis_liveliness);
  PublishTurning(state);
}

double Worst(const std::array<double, 9>& c) noexcept { return std::max({c[0], c[4], c[8]}); }

// Of a model's variance, the rest is the motion that it allows for: of a small gain's, half is noise without a velocity
// and three quarters with one. The latter is normalised to 1.
constexpr Likely kNoise{2.0 / 3, 1, 1};

// The noise in the estimate: sum mu n P. The models' differences are in it.
template <typename Estimate, typename VarianceOf>
double NoiseIn(const Models<Estimate>& models, const VarianceOf& variance) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < kModels; ++i) sum += models.likely[i] * kNoise[i] * variance(models.estimate[i]);
  return sum;
}

// As large as the noise, but with the velocity-to-position ratio of the constant-velocity model: that says how far the
// filter lags (docs/theory/haptics.md (3.3)); it lags less whenever another model takes over.
base::PointNoise Scaled(const base::PointNoise& moving, double noise_m2) noexcept {
  const double share = std::min(1.0, noise_m2 / moving.position_m2);
  return {share * moving.position_m2, share * moving.cross_m2_s, share * moving.velocity_m2_s2};
}

}  // namespace

void ResetFilter(const FilterNoise& noise, const PoseMeasurement& measured, FilterState& state) noexcept {
  state = FilterState{};
  ResetMotion(noise, measured, state);
  ResetTurning(noise, measured, state);
}

void PredictFilter(const FilterNoise& noise, double dt_s, bool pushed, FilterState& state) noexcept {
  const TransitionRates& follows_1_s = pushed ? noise.follows_pushed_1_s : noise.follows_1_s;
  PredictMotion(noise, follows_1_s, dt_s, state);
  PredictTurning(noise, follows_1_s, dt_s, state);
}

void CorrectFilter(const FilterNoise& noise, const PoseMeasurement& measured, double dt_s,
                   FilterState& state) noexcept {
  if (!CorrectMotion(noise, measured, dt_s, state)) return ResetFilter(noise, measured, state);
  CorrectTurning(noise, measured, dt_s, state);
}

// [Rodrigues] for a turn perpendicular to u: u cos|t| + (t x u) sin|t|/|t|; renormalised against drift.
base::Vec3 TurnAxis(const base::Vec3& axis, const base::Vec3& turn_rad) noexcept {
  const Vector3d u = base::ToEigen(axis);
  const Vector3d t = base::ToEigen(turn_rad);
  const double angle = t.norm();
  const double sinc = angle > 1e-8 ? std::sin(angle) / angle : 1.0;
  return base::FromEigen((std::cos(angle) * u + sinc * t.cross(u)).normalized());
}

// Position and axis are independent in the filter.
base::PointNoise NoiseOfPoint(const FilterState& filter, double offset_m) noexcept {
  const Motion& motion = filter.motions.estimate[kConstantVelocity];
  const Turning& turning = filter.turnings.estimate[kConstantVelocity];
  const double lever_m2 = offset_m * offset_m;
  return Scaled({Worst(motion.covariance_pp) + lever_m2 * turning.variance_angle,
                 Worst(motion.covariance_pv) + lever_m2 * turning.covariance_angle_rate,
                 Worst(motion.covariance_vv) + lever_m2 * turning.variance_rate},
                NoiseIn(filter.motions, [](const Motion& m) { return Worst(m.covariance_pp); }) +
                    lever_m2 * NoiseIn(filter.turnings, [](const Turning& t) { return t.variance_angle; }));
}

//   u' C u
base::PointNoise NoiseAlong(const FilterState& filter) noexcept {
  const Vector3d u = base::ToEigen(filter.axis_base);
  const auto along = [&](const std::array<double, 9>& c) { return u.dot(AsMatrix<3>(c) * u); };
  const Motion& motion = filter.motions.estimate[kConstantVelocity];
  return Scaled({along(motion.covariance_pp), along(motion.covariance_pv), along(motion.covariance_vv)},
                NoiseIn(filter.motions, [&](const Motion& m) { return along(m.covariance_pp); }));
}

}  // namespace omni::tracker
