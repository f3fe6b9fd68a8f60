#include "service/calibration/fit/window.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "service/base/eigen.h"

namespace omni::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kReadingsMin = 5;  // per sensor: a parabola and something left to judge it by

// y = c0 + c1 s + c2 s^2 per axis; s in [-1, 1] over the window.
struct WindowFit {
  bool valid = false;
  Matrix3d coefficients = Matrix3d::Zero();  // row: power, column: axis
  double scale = 0;                          // standard deviation of c0 in noise
  double slope_scale = 0;                    // and of c1
  double square = 0;                         // whitened residuals
  int dof = 0;
};

std::int64_t SampleTime(const base::HallScan& scan, std::size_t i) { return scan.t_ns - scan.age_ns[i]; }

Vector3d Powers(double s) { return {1, s, s * s}; }

WindowFit FitWindow(const std::vector<base::HallScan>& scans, std::size_t i, std::int64_t middle_ns, double half_s,
                    const std::array<double, 3>& noise_T) {
  const auto place = [&](const base::HallScan& scan) {
    return 1e-9 * static_cast<double>(SampleTime(scan, i) - middle_ns) / half_s;
  };
  Matrix3d N = Matrix3d::Zero(), right = Matrix3d::Zero();
  int count = 0;
  for (const base::HallScan& scan : scans) {
    if (((scan.fresh_mask >> i) & 1U) == 0) continue;
    const Vector3d s = Powers(place(scan));
    N += s * s.transpose();
    right += s * base::ToEigen(scan.field_sensor_T[i]).transpose();
    ++count;
  }
  WindowFit fit;
  if (count < kReadingsMin) return fit;
  const Eigen::LDLT<Matrix3d> solver(N);
  const Matrix3d inverse = solver.solve(Matrix3d::Identity());
  fit.coefficients = solver.solve(right);
  fit.valid = inverse.allFinite() && fit.coefficients.allFinite();
  fit.scale = std::sqrt(inverse(0, 0));
  fit.slope_scale = std::sqrt(inverse(1, 1));
  fit.dof = 3 * (count - 3);
  for (const base::HallScan& scan : scans) {
    if (((scan.fresh_mask >> i) & 1U) == 0) continue;
    const Vector3d residual =
        base::ToEigen(scan.field_sensor_T[i]) - fit.coefficients.transpose() * Powers(place(scan));
    for (int axis = 0; axis < 3; ++axis) {
      const double whitened = residual[axis] / noise_T[static_cast<std::size_t>(axis)];
      fit.square += whitened * whitened;
    }
  }
  return fit;
}

std::uint32_t Saturated(const std::vector<base::HallScan>& scans) {
  std::uint32_t mask = 0;
  for (const base::HallScan& scan : scans) mask |= scan.saturated_mask;
  return mask;
}

// |a - b| / |a| over the axes that both have.
double RelativeChange(const std::vector<base::Vec3>& a, const std::vector<base::Vec3>& b) {
  double change = 0, size = 0;
  const auto add = [&](double x, double y) {
    if (!(std::isfinite(x) && std::isfinite(y))) return;
    change += (x - y) * (x - y);
    size += x * x;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    add(a[i].x, b[i].x);
    add(a[i].y, b[i].y);
    add(a[i].z, b[i].z);
  }
  return size > 0 ? std::sqrt(change / size) : 0.0;
}

}  // namespace

Window::Window(const WindowOptions& options, const std::array<double, 3>& sensor_noise_T)
    : options_(options), noise_T_(sensor_noise_T) {
  scans_.reserve(static_cast<std::size_t>(options.scans));
}

std::optional<WindowResult> Window::Add(const base::HallScan& scan) {
  scans_.push_back(scan);
  if (scans_.size() < static_cast<std::size_t>(options_.scans)) return {};
  std::optional<WindowResult> result = Fit();
  scans_.clear();
  return result;
}

std::optional<WindowResult> Window::Fit() const {
  const std::int64_t first_ns = scans_.front().t_ns, last_ns = scans_.back().t_ns;
  const double half_s = 0.5e-9 * static_cast<double>(last_ns - first_ns);
  if (!(half_s > 0)) return {};
  const std::int64_t middle_ns = first_ns + (last_ns - first_ns) / 2;
  const std::uint32_t saturated = Saturated(scans_);
  WindowResult result;
  Sample& sample = result.sample;
  sample.t_s = 1e-9 * static_cast<double>(middle_ns);
  sample.noise_scale = 0;
  double square = 0, dof = 0, slope_square = 0, field_square = 0, slope_noise = 0;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const WindowFit fit = FitWindow(scans_, i, middle_ns, half_s, noise_T_);
    std::array<double, 3> field{kNaN, kNaN, kNaN};
    for (std::size_t axis = 0; fit.valid && axis < 3; ++axis) {
      const int a = static_cast<int>(axis);
      if (((saturated >> (3 * i + axis)) & 1U) != 0) continue;
      field[axis] = fit.coefficients(0, a);
      field_square += field[axis] * field[axis];
      slope_square += fit.coefficients(1, a) * fit.coefficients(1, a);
      slope_noise += fit.slope_scale * fit.slope_scale * noise_T_[axis] * noise_T_[axis];
    }
    sample.field_sensor_T.push_back({field[0], field[1], field[2]});
    if (!fit.valid) continue;
    sample.noise_scale = std::max(sample.noise_scale, fit.scale);
    square += fit.square;
    dof += fit.dof;
  }
  // A saturated axis does not follow a parabola, but shows nothing of the hand.
  if (!(dof > 0) || (saturated == 0 && !(square <= options_.misfit_max * dof))) return {};
  for (const base::HallScan& scan : scans_) {
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      sample.coil_current_A[k] += scan.coil_current_A[k] / static_cast<double>(scans_.size());
    }
  }
  result.still = std::sqrt(slope_square) <=
                 options_.still_relative * std::sqrt(field_square) + options_.still_sigmas * std::sqrt(slope_noise);
  return result;
}

std::optional<Sample> TouchPicker::Add(const WindowResult& window) {
  if (!window.still) {
    resting_ = 0;
    return {};
  }
  if (++resting_ < options_.windows_min) return {};
  const std::vector<base::Vec3>& field = window.sample.field_sensor_T;
  if (!last_sensor_T_.empty() && RelativeChange(field, last_sensor_T_) < options_.apart_relative) return {};
  last_sensor_T_ = field;
  Sample touch = window.sample;
  touch.touches_hull = true;
  return touch;
}

}  // namespace omni::calibration
