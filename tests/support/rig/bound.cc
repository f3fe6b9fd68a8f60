#include "tests/support/rig/bound.h"

#include <cmath>
#include <vector>

namespace omni::sim {
namespace {

constexpr double kStep_m = 1e-5;  // differences: h^2 / r^2 of the derivative is lost, 1e-7
constexpr double kStep_rad = 1e-4;
constexpr std::size_t kPoseSize = 5;
constexpr std::size_t kSizeMax = kPoseSize + base::kCoilCount + 3 + 1;

using Readings = std::array<Vec3, base::kSensorCount>;
using Column = std::array<double, 3 * base::kSensorCount>;

// The unknowns' derivatives, one column each, and their prior information (1 / rms^2).
struct Sensitivity {
  std::vector<Column> columns;
  std::vector<double> prior;
};

Column Difference(const Readings& plus, const Readings& minus, double scale) noexcept {
  Column column{};
  for (std::size_t i = 0; i < plus.size(); ++i) {
    const Vec3 d = scale * (plus[i] - minus[i]);
    column[3 * i] = d.x;
    column[3 * i + 1] = d.y;
    column[3 * i + 2] = d.z;
  }
  return column;
}

MagnetPose Moved(const MagnetPose& pose, const Vec3& by_m) noexcept {
  return {pose.centre_base_m + by_m, pose.axis_base};
}

MagnetPose Turned(const MagnetPose& pose, const Vec3& by_rad) noexcept {
  return {pose.centre_base_m, Normalized(pose.axis_base + by_rad)};
}

double Precision(double prior) noexcept { return std::isinf(prior) ? 0.0 : 1 / (prior * prior); }

Sensitivity Differentiate(Rig& rig, const MagnetPose& pose, const BoundOptions& options, const PoseBound& frame) {
  Sensitivity all;
  const auto add = [&](const Column& column, double precision) {
    all.columns.push_back(column);
    all.prior.push_back(precision);
  };
  const auto central = [&](const MagnetPose& plus, const MagnetPose& minus, double step) {
    add(Difference(rig.Readings(&plus, options.current_A), rig.Readings(&minus, options.current_A), 0.5 / step), 0);
  };
  for (const Vec3& e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    central(Moved(pose, kStep_m * e), Moved(pose, -kStep_m * e), kStep_m);
  }
  for (const Vec3& t : frame.tangent_base) {
    central(Turned(pose, kStep_rad * t), Turned(pose, -kStep_rad * t), std::tan(kStep_rad));
  }
  for (std::size_t k = 0; options.current_prior_A > 0 && k < base::kCoilCount; ++k) {
    CoilArray plus = options.current_A;
    CoilArray minus = options.current_A;
    plus[k] += 0.5;
    minus[k] -= 0.5;
    add(Difference(rig.Readings(&pose, plus), rig.Readings(&pose, minus), 1), Precision(options.current_prior_A));
  }
  for (std::size_t axis = 0; options.ambient_prior_T > 0 && axis < 3; ++axis) {
    Column column{};
    for (std::size_t i = 0; i < base::kSensorCount; ++i) {
      for (std::size_t row = 0; row < 3; ++row) {
        const Vec3& gain = rig.truth().sensor(i).rows[row];
        column[3 * i + row] = axis == 0 ? gain.x : axis == 1 ? gain.y : gain.z;
      }
    }
    add(column, Precision(options.ambient_prior_T));
  }
  if (options.moment_prior > 0) {
    add(Difference(rig.Readings(&pose, options.current_A), rig.Readings(nullptr, options.current_A), 1),
        Precision(options.moment_prior));
  }
  return all;
}

// Symmetric positive definite `a` (n x n in rows of kSizeMax) becomes its inverse, by Gauss-Jordan without exchange of
// rows; false: not positive definite. The unknowns are scaled to unit diagonal first: they mix metres and amperes.
bool Invert(std::array<double, kSizeMax * kSizeMax>& a, std::size_t n) noexcept {
  std::array<double, kSizeMax> scale{};
  for (std::size_t i = 0; i < n; ++i) {
    if (!(a[i * kSizeMax + i] > 0)) return false;
    scale[i] = 1 / std::sqrt(a[i * kSizeMax + i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) a[i * kSizeMax + j] *= scale[i] * scale[j];
  }
  for (std::size_t p = 0; p < n; ++p) {
    const double pivot = a[p * kSizeMax + p];
    if (!(pivot > 1e-12)) return false;
    a[p * kSizeMax + p] = 1;
    for (std::size_t j = 0; j < n; ++j) a[p * kSizeMax + j] /= pivot;
    for (std::size_t i = 0; i < n; ++i) {
      if (i == p) continue;
      const double factor = a[i * kSizeMax + p];
      a[i * kSizeMax + p] = 0;
      for (std::size_t j = 0; j < n; ++j) a[i * kSizeMax + j] -= factor * a[p * kSizeMax + j];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) a[i * kSizeMax + j] *= scale[i] * scale[j];
  }
  return true;
}

}  // namespace

// Information = sum over the axes of J^T J / sigma^2 + priors; its inverse's pose block is the bound with the other
// unknowns marginalised.
std::optional<PoseBound> CramerRao(Rig& rig, const MagnetPose& pose, const BoundOptions& options) {
  PoseBound bound;
  bound.tangent_base[0] = Perpendicular(pose.axis_base);
  bound.tangent_base[1] = Cross(pose.axis_base, bound.tangent_base[0]);
  const Sensitivity sensitivity = Differentiate(rig, pose, options, bound);
  const Readings readings = rig.Readings(&pose, options.current_A);
  const double range_T = rig.device().sensor_range_T;
  const std::size_t n = sensitivity.columns.size();
  std::array<double, kSizeMax * kSizeMax> information{};
  for (std::size_t i = 0; i < n; ++i) information[i * kSizeMax + i] = sensitivity.prior[i];
  for (std::size_t at = 0; at < 3 * base::kSensorCount; ++at) {
    const Vec3& b = readings[at / 3];
    const double reading_T = at % 3 == 0 ? b.x : at % 3 == 1 ? b.y : b.z;
    if (options.saturation && !(std::abs(reading_T) < range_T)) continue;
    const double weight = 1 / (options.noise_T[at % 3] * options.noise_T[at % 3]);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        information[i * kSizeMax + j] += weight * sensitivity.columns[i][at] * sensitivity.columns[j][at];
      }
    }
  }
  if (!Invert(information, n)) return std::nullopt;
  for (std::size_t i = 0; i < kPoseSize; ++i) {
    for (std::size_t j = 0; j < kPoseSize; ++j) bound.covariance[kPoseSize * i + j] = information[i * kSizeMax + j];
    (i < 3 ? bound.position_m2 : bound.orientation_rad2) += bound.covariance[kPoseSize * i + i];
  }
  return bound;
}

}  // namespace omni::sim
