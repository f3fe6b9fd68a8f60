#include "service/alignment/problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/alignment/rigid.h"
#include "service/base/eigen.h"

namespace omni::alignment {
namespace {

using base::ToEigen;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kYawStarts = 12;
constexpr int kStartIterations = 8;
constexpr std::size_t kRowsOfStart = 60;
constexpr int kIterations = 40;
constexpr int kPasses = 4;  // of noise and weights
constexpr double kSmallStep = 1e-12;
constexpr double kMedianOfChi3 = 1.5382;  // of the norm of three unit normals
constexpr double kHuber = 3.0;            // norms above this many sigma count less
constexpr double kTimeFixed_s = 1e-9;     // prior of a time offset that is not requested

Matrix3d Skew(const Vector3d& v) {
  Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Matrix3d Exp(const Vector3d& w) {
  const double angle = w.norm();
  return angle > 0 ? Eigen::AngleAxisd(angle, w / angle).toRotationMatrix() : Matrix3d::Identity();
}

Unknowns Moved(const Unknowns& x, const Step& step) {
  Unknowns y = x;
  y.R_LB = Exp(step.segment<3>(0)) * x.R_LB;
  y.p_LB += step.segment<3>(3);
  y.l += step.segment<3>(6);
  y.tau_s += step(9);
  return y;
}

}  // namespace

Problem::Problem(const std::vector<Sample>& samples, const Prior& prior)
    : prior_(prior), weights_(samples.size(), 1.0), noise_m_(prior.noise_m) {
  rows_.reserve(samples.size());
  for (const Sample& sample : samples) {
    rows_.push_back({.R_LC = ToEigen(sample.controller_space.orientation).normalized().toRotationMatrix(),
                     .p_LC = ToEigen(sample.controller_space.position_m),
                     .p_B = ToEigen(sample.point_base_m),
                     .v_B = ToEigen(sample.velocity_base_m_s),
                     .group = sample.group});
  }
}

Vector3d Problem::Residual(const Row& row, const Unknowns& x) const {
  return row.R_LC * x.l + row.p_LC - (x.R_LB * (row.p_B + row.v_B * x.tau_s) + x.p_LB);
}

double Problem::Cost(const Unknowns& x) const {
  const double w_noise = 1 / (noise_m_ * noise_m_ * correlation_);
  double cost = 0;
  for (std::size_t k = 0; k < rows_.size(); k += stride_) {
    cost += w_noise * weights_[k] * Residual(rows_[k], x).squaredNorm();
  }
  cost += (x.l - ToEigen(prior_.tip_controller_m)).squaredNorm() / (prior_.tip_sigma_m * prior_.tip_sigma_m);
  const double tau_sigma_s = prior_.time_offset ? prior_.time_offset_sigma_s : kTimeFixed_s;
  cost += x.tau_s * x.tau_s / (tau_sigma_s * tau_sigma_s);
  if (prior_.level) {
    const Vector3d up = x.R_LB.col(2);
    cost += (up.x() * up.x() + up.z() * up.z()) / (prior_.level_sigma_rad * prior_.level_sigma_rad);
    if (up.y() < 0) cost += 1e6;  // the residual above does not see a base that stands on its head
  }
  return cost;
}

Problem::Jacobian Problem::JacobianOf(const Row& row, const Unknowns& x) {
  Jacobian J;
  J.block<3, 3>(0, 0) = Skew(x.R_LB * (row.p_B + row.v_B * x.tau_s));
  J.block<3, 3>(0, 3) = -Matrix3d::Identity();
  J.block<3, 3>(0, 6) = row.R_LC;
  J.col(9) = -x.R_LB * row.v_B;
  return J;
}

void Problem::Linearise(const Unknowns& x, Normal& H, Step& g) const {
  H.setZero();
  g.setZero();
  const double w_noise = 1 / (noise_m_ * noise_m_ * correlation_);
  for (std::size_t k = 0; k < rows_.size(); k += stride_) {
    const Jacobian J = JacobianOf(rows_[k], x);
    const double w = w_noise * weights_[k];
    H.noalias() += w * J.transpose() * J;
    g.noalias() += w * J.transpose() * Residual(rows_[k], x);
  }
  const double w_tip = 1 / (prior_.tip_sigma_m * prior_.tip_sigma_m);
  H.block<3, 3>(6, 6).diagonal().array() += w_tip;
  g.segment<3>(6) += w_tip * (x.l - ToEigen(prior_.tip_controller_m));
  const double tau_sigma_s = prior_.time_offset ? prior_.time_offset_sigma_s : kTimeFixed_s;
  H(9, 9) += 1 / (tau_sigma_s * tau_sigma_s);
  g(9) += x.tau_s / (tau_sigma_s * tau_sigma_s);
  if (!prior_.level) return;
  // up = R_LB e_z must be e_y: its x and z vanish;  d up = w x up = -[up]x w
  const Matrix3d D = -Skew(x.R_LB.col(2));
  const double w_level = 1 / (prior_.level_sigma_rad * prior_.level_sigma_rad);
  for (const int axis : {0, 2}) {
    H.block<3, 3>(0, 0) += w_level * D.row(axis).transpose() * D.row(axis);
    g.segment<3>(0) += w_level * D.row(axis).transpose() * x.R_LB(axis, 2);
  }
}

// Gauss-Newton, damped when a step does not help.
Unknowns Problem::Descend(Unknowns x, int iterations) const {
  double cost = Cost(x), damping = 0;
  Normal H;
  Step g;
  for (int i = 0; i < iterations; ++i) {
    Linearise(x, H, g);
    Normal damped = H;
    damped.diagonal() *= 1 + damping;
    const Step step = -damped.llt().solve(g);
    if (!step.allFinite()) break;
    const Unknowns y = Moved(x, step);
    const double moved = Cost(y);
    if (moved <= cost) {
      x = y;
      const bool done = cost - moved <= kSmallStep * cost && step.norm() < 1e-9;
      cost = moved;
      damping *= 0.1;
      if (done) break;
    } else {
      damping = std::max(10 * damping, 1e-3);
      if (damping > 1e9) break;
    }
  }
  return x;
}

std::vector<Matrix3d> Problem::Starts() const {
  const Matrix3d R_level = ToEigen(LevelBase().orientation).toRotationMatrix();
  std::vector<Matrix3d> starts;
  const auto add_yaws = [&](const Matrix3d& R, int count) {
    for (int i = 0; i < count; ++i) {
      starts.push_back(Eigen::AngleAxisd(2 * std::numbers::pi * i / count, Vector3d::UnitY()) * R);
    }
  };
  if (prior_.level) {
    add_yaws(R_level, kYawStarts);
    return starts;
  }
  const double quarter = std::numbers::pi / 2;
  for (int i = 0; i < 4; ++i) add_yaws(Eigen::AngleAxisd(i * quarter, Vector3d::UnitX()) * R_level, 4);
  for (const int i : {-1, 1}) add_yaws(Eigen::AngleAxisd(i * quarter, Vector3d::UnitZ()) * R_level, 4);
  return starts;
}

// Huber: w = min(1, k sigma / |r|), sigma by the median.
void Problem::UpdateWeights() {
  if (!prior_.robust) return;
  std::vector<double> norms;
  norms.reserve(residuals_.size());
  for (const Vector3d& r : residuals_) norms.push_back(r.norm());
  std::vector<double> sorted = norms;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double sigma = std::max(sorted[sorted.size() / 2] / kMedianOfChi3, 1e-6);
  for (std::size_t k = 0; k < norms.size(); ++k) {
    weights_[k] = norms[k] <= kHuber * sigma ? 1.0 : kHuber * sigma / norms[k];
  }
}

// Correlated samples carry less information than their number. kappa = 1 + 2 sum rho_i over the lags up to the first
// rho below 0.05, within groups only;   s^2 = (nu s0^2 + SSR/kappa) / (nu + 3 n/kappa - p)
// [docs/theory/alignment.md (5), (6)]
void Problem::UpdateNoise() {
  const std::size_t n = residuals_.size();
  double ssr = 0, weight = 0;
  for (std::size_t k = 0; k < n; ++k) {
    ssr += weights_[k] * residuals_[k].squaredNorm();
    weight += weights_[k];
  }
  correlation_ = 1;
  rho_.clear();
  for (std::size_t lag = 1; lag < n / 3 && ssr > 0; ++lag) {
    double sum = 0;
    for (std::size_t k = lag; k < n; ++k) {
      if (rows_[k].group != rows_[k - lag].group) continue;
      sum += std::sqrt(weights_[k] * weights_[k - lag]) * residuals_[k].dot(residuals_[k - lag]);
    }
    const double rho = sum / ssr;
    if (!(rho > 0.05)) break;
    rho_.push_back(rho);
    correlation_ += 2 * rho;
  }
  const double tip_known = prior_.tip_sigma_m < 10 * prior_.noise_m ? 0 : 3;
  const double parameters = (prior_.level ? 4 : 6) + tip_known + (prior_.time_offset ? 1 : 0);
  const double freedom = std::max(0.0, 3 * weight / correlation_ - parameters);
  const double s2 =
      (prior_.noise_weight * prior_.noise_m * prior_.noise_m + ssr / correlation_) / (prior_.noise_weight + freedom);
  noise_m_ = std::sqrt(s2);
}

bool Problem::Solve() {
  stride_ = std::max<std::size_t>(1, rows_.size() / kRowsOfStart);
  double best = std::numeric_limits<double>::infinity();
  for (const Matrix3d& R : Starts()) {
    Unknowns start;
    start.R_LB = R;
    start.l = ToEigen(prior_.tip_controller_m);
    Vector3d gap = Vector3d::Zero();
    for (const Row& row : rows_) gap += Residual(row, start);
    start.p_LB = gap / static_cast<double>(rows_.size());
    const Unknowns end = Descend(start, kStartIterations);
    const double cost = Cost(end);
    if (cost < best) best = cost, x_ = end;
  }
  if (!std::isfinite(best)) return false;
  stride_ = 1;
  residuals_.resize(rows_.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    x_ = Descend(x_, kIterations);
    for (std::size_t k = 0; k < rows_.size(); ++k) residuals_[k] = Residual(rows_[k], x_);
    UpdateWeights();
    UpdateNoise();
  }
  return x_.R_LB.allFinite() && x_.p_LB.allFinite() && x_.l.allFinite();
}

// Sandwich: lasting noise counts as far as the motion lasts as well.
//   S = w^2 s^2 sum_i rho_i sum_k J_k^T J_{k-i} + P,   Cov = A^-1 S A^-1,   A = w sum J^T J + P
// with P the priors' part.                                                          [docs/theory/alignment.md (7)]
Normal Problem::Covariance() const {
  Normal A;
  Step g;
  Linearise(x_, A, g);
  const double w_noise = 1 / (noise_m_ * noise_m_ * correlation_);
  std::vector<Jacobian> J;
  J.reserve(rows_.size());
  Normal data = Normal::Zero(), lasting = Normal::Zero();
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    J.push_back(std::sqrt(weights_[k]) * JacobianOf(rows_[k], x_));
    data.noalias() += J[k].transpose() * J[k];
    for (std::size_t i = 0; i < rho_.size() && i < k; ++i) {
      if (rows_[k].group != rows_[k - i - 1].group) continue;
      lasting.noalias() += rho_[i] * J[k].transpose() * J[k - i - 1];
    }
  }
  const Normal P = A - w_noise * data;
  const Normal S = w_noise / correlation_ * (data + lasting + lasting.transpose()) + P;
  const Normal inverse = A.llt().solve(Normal::Identity());
  return inverse * S * inverse;
}

}  // namespace omni::alignment
