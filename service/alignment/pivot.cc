#include "service/alignment/dwell.h"

#include <cmath>
#include <cstdio>

#include <Eigen/Dense>

#include "service/base/eigen.h"

namespace omni::alignment {
namespace {

using base::ToEigen;
using Eigen::Vector3d;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastTurn = 0.01;  // smallest eigenvalue of the spread of rotations: 10 degrees or so about two axes

std::string PivotText(const char* format, double metres) {
  char text[200];
  std::snprintf(text, sizeof text, format, metres * 1e3);
  return text;
}

// Neighbouring residuals are correlated: 1 + 2 sum rho.
double Correlation(const std::vector<Vector3d>& residuals, double ssr) {
  double correlation = 1;
  for (std::size_t lag = 1; lag < residuals.size() / 3 && ssr > 0; ++lag) {
    double sum = 0;
    for (std::size_t k = lag; k < residuals.size(); ++k) sum += residuals[k].dot(residuals[k - lag]);
    if (!(sum / ssr > 0.05)) break;
    correlation += 2 * sum / ssr;
  }
  return correlation;
}

}  // namespace

base::Result<Pivot> SolvePivot(const std::vector<Rigid>& controller_space) {
  if (static_cast<int>(controller_space.size()) < kPivotPoses_min) {
    return base::Error{"the controller was tracked in " + std::to_string(controller_space.size()) +
                       " poses only, at least " + std::to_string(kPivotPoses_min) +
                       " are needed; swing it for some seconds"};
  }
  Matrix6 H = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  Eigen::Matrix<double, 3, 6> A;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (const Rigid& pose : controller_space) {
    const Eigen::Matrix3d R = ToEigen(pose.orientation).normalized().toRotationMatrix();
    A << R, -Eigen::Matrix3d::Identity();
    H += A.transpose() * A;
    g -= A.transpose() * ToEigen(pose.position_m);
    mean += R;
  }
  const double n = static_cast<double>(controller_space.size());
  mean /= n;
  // What is left of l after the best c: I - mean^T mean. Zero along an axis that everything turned about.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(Eigen::Matrix3d::Identity() - mean.transpose() * mean);
  if (!(spread.eigenvalues()(0) >= kLeastTurn)) {
    return base::Error{
        "the controller was turned too little, or about one axis only; swing it to all sides by 30 "
        "degrees, and twist it"};
  }
  const Eigen::LLT<Matrix6> factors(H);
  const Vector6 solution = factors.solve(g);
  std::vector<Vector3d> residuals;
  double ssr = 0;
  for (const Rigid& pose : controller_space) {
    const Eigen::Matrix3d R = ToEigen(pose.orientation).normalized().toRotationMatrix();
    residuals.push_back(R * solution.head<3>() + ToEigen(pose.position_m) - solution.tail<3>());
    ssr += residuals.back().squaredNorm();
  }
  Pivot pivot{.tip_controller_m = base::FromEigen(solution.head<3>()),
              .centre_space_m = base::FromEigen(solution.tail<3>()),
              .rms_m = std::sqrt(ssr / n)};
  const double freedom = std::max(1.0, 3 * n - 6);
  const Matrix6 covariance = factors.solve(Matrix6::Identity()) * (ssr / freedom * Correlation(residuals, ssr));
  pivot.tip_sigma_m = std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
  if (!(pivot.rms_m <= kPivotRms_max_m)) {
    return base::Error{
        PivotText("the tip moved by %.1f mm rms, the limit is 5 mm; press it into the dimple and swing "
                  "slowly, in the cameras' view",
                  pivot.rms_m)};
  }
  if (!(pivot.tip_sigma_m <= kPivotSigma_max_m)) {
    return base::Error{
        PivotText("the tip is known to %.1f mm, the limit is 3 mm; swing further, and longer", pivot.tip_sigma_m)};
  }
  return pivot;
}

}  // namespace omni::alignment
