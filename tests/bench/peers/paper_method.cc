#include "tests/bench/peers/paper_method.h"

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include <ceres/ceres.h>

#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"

namespace omni::peers {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

// The search runs in units that make all five parameters and the cost of the order of one.
constexpr double kLength_m = 0.05;
constexpr double kGauss_T = 1e-4;

Vector3d AxisFrom(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// Eq. 5 with B_n and B_e already subtracted from the readings: sum w (R_SB B(s - p, m) - y)^2, in gauss^2.
class PaperCost final : public ceres::FirstOrderFunction {
 public:
  explicit PaperCost(PaperModel model)
      : model_(std::move(model)), tool_sensor_T_(model_.sensor_position_base_m.size()) {}

  void Load(const PaperScan& scan) {
    const RowMajor3d C = Eigen::Map<const RowMajor3d>(model_.moment_per_ampere_Am2_A.data());
    const Vector3d m_e = C * Vector3d(scan.current_A[0], scan.current_A[1], scan.current_A[2]);
    for (std::size_t i = 0; i < tool_sensor_T_.size(); ++i) {
      const Vector3d B_e = magnetics::DipoleField(m_e, base::ToEigen(model_.sensor_position_base_m[i]));
      tool_sensor_T_[i] = base::ToEigen(scan.field_sensor_T[i]) - Orientation(i) * B_e;
    }
    saturated_mask_ = scan.saturated_mask;
    evaluations_ = 0;
  }

  bool Evaluate(const double* x, double* cost, double* gradient) const override {
    ++evaluations_;
    const Vector3d p = kLength_m * Vector3d(x[0], x[1], x[2]);
    const double theta = x[3], phi = x[4];
    const double m = model_.moment_Am2;
    const Vector3d u = AxisFrom(theta, phi);
    const Vector3d u_theta(std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi), -std::sin(theta));
    const Vector3d u_phi(-std::sin(theta) * std::sin(phi), std::sin(theta) * std::cos(phi), 0);
    Vector3d by_position = Vector3d::Zero(), by_axis = Vector3d::Zero();
    double sum = 0;
    for (std::size_t i = 0; i < tool_sensor_T_.size(); ++i) {
      const Vector3d d = base::ToEigen(model_.sensor_position_base_m[i]) - p;
      const Vector3d r = Weighted(i, Orientation(i) * magnetics::DipoleField(m * u, d) - tool_sensor_T_[i]);
      sum += r.squaredNorm();
      if (gradient == nullptr) continue;
      const Vector3d r_base = Orientation(i).transpose() * r;
      by_position -= magnetics::DipoleGradient(m * u, d) * r_base;
      by_axis += m * (magnetics::DipoleMatrix(d) * r_base);
    }
    const double scale = 1 / (kGauss_T * kGauss_T);
    *cost = scale * sum;
    if (gradient != nullptr) {
      Eigen::Map<Vector3d>(gradient, 3) = 2 * scale * kLength_m * by_position;
      gradient[3] = 2 * scale * by_axis.dot(u_theta);
      gradient[4] = 2 * scale * by_axis.dot(u_phi);
    }
    return std::isfinite(*cost);
  }

  int NumParameters() const override { return 5; }

  double ResidualRms_T(double cost) const {
    int used = 0;
    for (std::size_t bit = 0; bit < 3 * tool_sensor_T_.size(); ++bit) used += (saturated_mask_ >> bit) & 1U ? 0 : 1;
    return used > 0 ? kGauss_T * std::sqrt(cost / used) : 0;
  }
  int evaluations() const { return evaluations_; }

 private:
  Eigen::Map<const RowMajor3d> Orientation(std::size_t i) const {
    return Eigen::Map<const RowMajor3d>(model_.orientation_sensor_base[i].data());
  }

  Vector3d Weighted(std::size_t i, Vector3d r) const {
    for (int axis = 0; axis < 3; ++axis) {
      if ((saturated_mask_ >> (3 * i + static_cast<std::size_t>(axis))) & 1U) r[axis] = 0;
    }
    return r;
  }

  PaperModel model_;
  std::vector<Vector3d> tool_sensor_T_;
  std::uint64_t saturated_mask_ = 0;
  mutable int evaluations_ = 0;
};

std::array<double, 5> ParametersOf(const PaperPose& pose) {
  const base::Vec3& p = pose.position_base_m;
  return {p.x / kLength_m, p.y / kLength_m, p.z / kLength_m, pose.theta_rad, pose.phi_rad};
}

}  // namespace

base::Vec3 AxisOf(const PaperPose& pose) noexcept { return base::FromEigen(AxisFrom(pose.theta_rad, pose.phi_rad)); }

PaperPose PoseOf(const base::Vec3& position_base_m, const base::Vec3& axis_base) noexcept {
  return {position_base_m, std::atan2(std::hypot(axis_base.x, axis_base.y), axis_base.z),
          std::atan2(axis_base.y, axis_base.x)};
}

PaperModel MakePaperModel(const base::Calibration& drawn, std::span<const base::Vec3> sweep_T_A) {
  PaperModel model;
  model.moment_Am2 = drawn.moment_Am2;
  const int rows = 3 * static_cast<int>(drawn.sensors.size());
  Eigen::MatrixXd A(rows, 3), Y(rows, 3);
  for (std::size_t i = 0; i < drawn.sensors.size(); ++i) {
    model.sensor_position_base_m.push_back(drawn.sensors[i].position_base_m);
    model.orientation_sensor_base.push_back(drawn.sensors[i].gain_sensor_base);
    const RowMajor3d R_SB = Eigen::Map<const RowMajor3d>(drawn.sensors[i].gain_sensor_base.data());
    const int row = 3 * static_cast<int>(i);
    A.middleRows<3>(row) = R_SB * magnetics::DipoleMatrix(base::ToEigen(drawn.sensors[i].position_base_m));
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      Y.block<3, 1>(row, static_cast<int>(k)) = base::ToEigen(sweep_T_A[3 * i + k]);
    }
  }
  Eigen::Map<RowMajor3d>(model.moment_per_ampere_Am2_A.data()) = A.colPivHouseholderQr().solve(Y);
  return model;
}

struct PaperSolver::Problem {
  PaperCost* cost;  // owned by `gradient_problem`
  ceres::GradientProblem gradient_problem;
  ceres::GradientProblemSolver::Options options;

  explicit Problem(PaperModel model) : cost(new PaperCost(std::move(model))), gradient_problem(cost) {
    options.line_search_direction_type = ceres::LBFGS;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-9;
    options.gradient_tolerance = 1e-12;
    options.parameter_tolerance = 1e-9;
    options.logging_type = ceres::SILENT;
  }

  PaperFit Minimise(const PaperPose& start) {
    std::array<double, 5> x = ParametersOf(start);
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(options, gradient_problem, x.data(), &summary);
    PaperFit fit;
    fit.pose = {{kLength_m * x[0], kLength_m * x[1], kLength_m * x[2]}, x[3], x[4]};
    fit.residual_rms_T = cost->ResidualRms_T(summary.final_cost);
    fit.converged = summary.termination_type == ceres::CONVERGENCE && std::isfinite(fit.residual_rms_T);
    return fit;
  }
};

PaperSolver::PaperSolver(PaperModel model) : problem_(std::make_unique<Problem>(std::move(model))) {}
PaperSolver::~PaperSolver() = default;

PaperFit PaperSolver::Solve(const PaperScan& scan, const PaperPose& start) {
  problem_->cost->Load(scan);
  PaperFit fit = problem_->Minimise(start);
  fit.evaluations = problem_->cost->evaluations();
  return fit;
}

PaperFit PaperSolver::SolveCold(const PaperScan& scan) {
  problem_->cost->Load(scan);
  PaperFit best = problem_->Minimise(PaperPose{});
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4;
    const Vector3d outwards(0.8 * std::cos(angle), 0.8 * std::sin(angle), 0.6);
    const PaperFit fit = problem_->Minimise(PoseOf(base::FromEigen(0.065 * outwards), base::FromEigen(-outwards)));
    if (fit.residual_rms_T < best.residual_rms_T) best = fit;
  }
  best.evaluations = problem_->cost->evaluations();
  return best;
}

double PaperSolver::Cost(const PaperScan& scan, const PaperPose& pose, std::array<double, 5>& gradient) const {
  problem_->cost->Load(scan);
  const std::array<double, 5> x = ParametersOf(pose);
  double cost = 0;
  problem_->cost->Evaluate(x.data(), &cost, gradient.data());
  for (std::size_t i = 0; i < 3; ++i) gradient[i] /= kLength_m;
  return cost;
}

}  // namespace omni::peers
