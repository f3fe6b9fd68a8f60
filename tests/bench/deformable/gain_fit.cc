#include "tests/bench/deformable/gain_fit.h"

#include <Eigen/Core>
#include <Eigen/QR>
#include <cmath>

namespace omni::bench {

GainFit FitGain(const AxisMesh& mesh) {
  constexpr double kBall_m = 0.004;
  constexpr double kPoisson[] = {0, 0.15, 0.3, 0.38, 0.45};
  const AxisBody half_space{"half-space", 300 * kBall_m, 300 * kBall_m, 0};
  std::vector<double> depths_m;
  for (const double share : {0.05, 0.09, 0.15, 0.22, 0.3, 0.38, 0.46, 0.55}) depths_m.push_back(share * kBall_m);
  GainFit fit;
  std::vector<Eigen::Matrix<double, 6, 1>> rows;
  std::vector<double> gains;
  for (const double nu : kPoisson) {
    const AxisCurve curve = PressBall(half_space, nu, kBall_m, depths_m, mesh);
    fit.converged = fit.converged && curve.converged;
    for (std::size_t k = 0; k < depths_m.size(); ++k) {
      const double hertz = 4.0 / 3 / (1 - nu * nu) * std::sqrt(kBall_m) * std::pow(depths_m[k], 1.5);
      const double s = std::sqrt(depths_m[k] / kBall_m);
      Eigen::Matrix<double, 6, 1> row;
      row << s, s * nu, s * nu * nu, s * s, s * s * nu, s * s * nu * nu;
      rows.push_back(row);
      gains.push_back(curve.force_per_modulus_m2[k] / hertz - 1);
    }
  }
  Eigen::MatrixXd a(static_cast<Eigen::Index>(rows.size()), 6);
  Eigen::VectorXd b(a.rows());
  for (Eigen::Index k = 0; k < a.rows(); ++k) {
    a.row(k) = rows[static_cast<std::size_t>(k)].transpose();
    b[k] = gains[static_cast<std::size_t>(k)];
  }
  const Eigen::VectorXd x = a.colPivHouseholderQr().solve(b);
  fit.linear = {x[0], x[1], x[2]};
  fit.quadratic = {x[3], x[4], x[5]};
  fit.worst = (a * x - b).cwiseAbs().maxCoeff();
  fit.points = static_cast<int>(a.rows());
  return fit;
}

}  // namespace omni::bench
