#include "service/tracker/room/point_noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

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
  const Eigen::Vector3d u = base::ToEigen(filter.axis_base);
  const auto along = [&](const std::array<double, 9>& c) {
    return u.dot(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(c.data()) * u);
  };
  const Motion& motion = filter.motions.estimate[kConstantVelocity];
  return Scaled({along(motion.covariance_pp), along(motion.covariance_pv), along(motion.covariance_vv)},
                NoiseIn(filter.motions, [&](const Motion& m) { return along(m.covariance_pp); }));
}

}  // namespace omni::tracker
