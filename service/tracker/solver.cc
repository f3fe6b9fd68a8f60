#include "service/tracker/solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "service/magnetics/disc_magnet.h"

namespace omni::tracker {
namespace {

using Vector5d = Eigen::Matrix<double, kParameters, 1>;

constexpr double kStepMax_m = 0.03;  // of one iteration
constexpr double kTurnMax_rad = 0.7;
constexpr double kDecrementDone = 1e-3;  // d^T JtJ d: the step is 3 % of a standard deviation
constexpr double kDampingFirst = 1e-4;   // after the first refused step
constexpr double kDampingNewton = 1e-3;  // below this a step counts as a Gauss-Newton step
constexpr double kDampingMax = 1e8;

void Store(const Eigen::Vector3d& v, std::array<double, 3>& out) noexcept { out = {v.x(), v.y(), v.z()}; }

// (JtJ + damping diag(JtJ)) d = -Jtr   [Marquardt 1963]
Vector5d DampedStep(const Matrix5d& H, const Vector5d& g, double damping) noexcept {
  Matrix5d A = H;
  A.diagonal() *= 1 + damping;
  Vector5d d = -A.ldlt().solve(g);
  const double shrink = std::max({1.0, d.head<3>().norm() / kStepMax_m, d.tail<2>().norm() / kTurnMax_rad});
  return d / shrink;
}

// p + dp; u + a e1 + b e2, normalised: a step on the sphere without a singular direction.
Pose Retract(const Pose& pose, const PosePoint& point, const Vector5d& d) noexcept {
  const Eigen::Map<const Eigen::Vector3d> e1(point.tangent_1_base.data());
  const Eigen::Map<const Eigen::Vector3d> e2(point.tangent_2_base.data());
  return {pose.position_base_m + d.head<3>(), (pose.axis_base + d[3] * e1 + d[4] * e2).normalized()};
}

}  // namespace

PosePoint MakePosePoint(const Pose& pose) noexcept {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(pose.axis_base);
  PosePoint point;
  Store(pose.position_base_m, point.position_base_m);
  Store(pose.axis_base, point.axis_base);
  Store(basis.e1, point.tangent_1_base);
  Store(basis.e2, point.tangent_2_base);
  return point;
}

Fit SolvePose(const Model& model, const Measurement& measurement, const Pose& start, double damping,
              int iterations_max) noexcept {
  Fit fit;
  fit.pose = start;
  PosePoint point = MakePosePoint(start);
  NormalEquations current;
  Linearise(model, measurement, point, current);
  fit.iterations = 1;
  fit.chi2 = current.chi2;
  if (!std::isfinite(current.chi2)) return fit;

  double lambda = damping;
  for (;;) {
    const Matrix5d H = Eigen::Map<const Matrix5d>(current.JtJ.data());
    const Vector5d g = Eigen::Map<const Vector5d>(current.Jtr.data());
    const Vector5d d = DampedStep(H, g, lambda);
    if (!d.allFinite()) break;
    const Pose candidate = Retract(fit.pose, point, d);
    const double decrement = d.dot(H * d);
    if (decrement < kDecrementDone && lambda <= kDampingNewton) {
      // The quadratic model is exact at this size: take the step without another evaluation.
      fit.pose = candidate;
      fit.chi2 = std::max(0.0, current.chi2 + 2 * g.dot(d) + decrement);
      fit.covariance = H.ldlt().solve(Matrix5d::Identity());
      fit.converged = fit.covariance.allFinite() && (fit.covariance.diagonal().array() > 0).all();
      break;
    }
    if (fit.iterations >= iterations_max) break;
    const PosePoint next_point = MakePosePoint(candidate);
    NormalEquations next;
    Linearise(model, measurement, next_point, next);
    ++fit.iterations;
    if (next.chi2 <= current.chi2) {  // false for NaN
      current = next;
      point = next_point;
      fit.pose = candidate;
      fit.chi2 = next.chi2;
      lambda = lambda > 1e-9 ? lambda * 0.1 : 0;
    } else {
      lambda = std::max(kDampingFirst, lambda * 10);
      if (!(lambda < kDampingMax)) break;
    }
  }
  return fit;
}

}  // namespace omni::tracker
