#include "tests/bench/peers/ceres_pose.h"

#include <ceres/ceres.h>

namespace omni::peers {
namespace {

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

ceres::Solver::Options SolverOptions(PeerLinearSolver linear, const PeerOptions& peer) {
  ceres::Solver::Options options;
  options.linear_solver_type = linear == PeerLinearSolver::kDenseQr ? ceres::DENSE_QR : ceres::DENSE_NORMAL_CHOLESKY;
  options.num_threads = 1;
  options.max_num_iterations = peer.iterations_max;
  options.function_tolerance = peer.function_tolerance;
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  return options;
}

}  // namespace

struct CeresPose::Parts {
  std::unique_ptr<ceres::CostFunction> cost;
  ceres::SphereManifold<3> sphere;
  std::array<double, 3> position{};
  std::array<double, 3> axis{0, 0, -1};
  ceres::Solver::Options options;
  ceres::Problem problem;

  Parts(std::unique_ptr<ceres::CostFunction> cost_in, PeerLinearSolver linear, const PeerOptions& peer)
      : cost(std::move(cost_in)), options(SolverOptions(linear, peer)), problem(ProblemOptions()) {
    problem.AddResidualBlock(cost.get(), nullptr, position.data(), axis.data());
    problem.SetManifold(axis.data(), &sphere);
  }
};

CeresPose::CeresPose(std::unique_ptr<ceres::CostFunction> cost, PeerLinearSolver linear, const PeerOptions& options)
    : parts_(std::make_unique<Parts>(std::move(cost), linear, options)) {}
CeresPose::~CeresPose() = default;

PeerFit CeresPose::Solve(const PeerPose& start) {
  std::array<double, 3>& p = parts_->position;
  std::array<double, 3>& u = parts_->axis;
  p = {start.position_base_m.x, start.position_base_m.y, start.position_base_m.z};
  u = {start.axis_base.x, start.axis_base.y, start.axis_base.z};
  ceres::Solver::Summary summary;
  ceres::Solve(parts_->options, &parts_->problem, &summary);
  return {.pose = {{p[0], p[1], p[2]}, {u[0], u[1], u[2]}},
          .chi2 = 2 * summary.final_cost,
          .iterations = static_cast<int>(summary.iterations.size()),
          .converged = summary.termination_type == ceres::CONVERGENCE};
}

}  // namespace omni::peers
