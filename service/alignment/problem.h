// Gauss-Newton on the joint problem. Private to this folder.
//
//   r_k = R_LC l + p_LC - ( R_LB (p_B + v_B tau) + p_LB )            [docs/theory/alignment.md (3)]
//
// unknown: R_LB (by a rotation vector in L), p_LB, l, tau.
#pragma once

#include <vector>

#include <Eigen/Dense>

#include "service/alignment/types.h"

namespace omni::alignment {

struct Unknowns {
  Eigen::Matrix3d R_LB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_LB = Eigen::Vector3d::Zero();
  Eigen::Vector3d l = Eigen::Vector3d::Zero();
  double tau_s = 0;
};

inline constexpr int kUnknowns = 10;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Step = Eigen::Matrix<double, kUnknowns, 1>;

class Problem {
 public:
  Problem(const std::vector<Sample>& samples, const Prior& prior);

  // From the best of many rotations, with noise and weights found on the way. False: no start converged.
  bool Solve();

  const Unknowns& unknowns() const { return x_; }
  const std::vector<Eigen::Vector3d>& residuals() const { return residuals_; }
  const std::vector<double>& weights() const { return weights_; }
  double noise_m() const { return noise_m_; }          // per axis and sample
  double correlation() const { return correlation_; }  // samples worth one independent one
  Normal Covariance() const;

 private:
  struct Row {
    Eigen::Matrix3d R_LC;
    Eigen::Vector3d p_LC, p_B, v_B;
    int group = 0;
  };
  using Jacobian = Eigen::Matrix<double, 3, kUnknowns>;
  static Jacobian JacobianOf(const Row& row, const Unknowns& x);
  Eigen::Vector3d Residual(const Row& row, const Unknowns& x) const;
  double Cost(const Unknowns& x) const;
  void Linearise(const Unknowns& x, Normal& H, Step& g) const;
  Unknowns Descend(Unknowns x, int iterations) const;
  // Starts: level bases by yaw, or all 24 rotations of a cube.
  std::vector<Eigen::Matrix3d> Starts() const;
  void UpdateWeights();
  void UpdateNoise();

  Prior prior_;
  std::vector<Row> rows_;
  std::vector<double> weights_;
  std::vector<Eigen::Vector3d> residuals_;
  Unknowns x_;
  double noise_m_;
  std::vector<double> rho_;  // autocorrelation of the residuals at lags 1, 2, ... up to the first that is small
  double correlation_ = 1;
  std::size_t stride_ = 1;  // every how many-th row counts: a start needs few
};

}  // namespace omni::alignment
