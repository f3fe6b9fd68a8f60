#include <ceres/tiny_solver.h>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "tests/bench/peers/analytic.h"

namespace omni::peers {
namespace {

// TinySolver compares the change of the cost itself, not its share; the cost of a fit is half its 19 degrees of
// freedom.
constexpr double kTypicalCost = 0.5 * (kPeerReadings - tracker::kParameters);

// Parameters: position, and the axis as u = normalise(u0 + a t1 + b t2) about the start u0. The derivative of the
// normalised vector along t is its component across u, over the length of u0 + a t1 + b t2.
struct TinyCost {
  using Scalar = double;
  enum { NUM_RESIDUALS = kPeerReadings, NUM_PARAMETERS = tracker::kParameters };

  const tracker::Model& model;
  const PeerScan* scan = nullptr;
  Eigen::Vector3d u0 = -Eigen::Vector3d::UnitZ();
  Eigen::Vector3d t1 = Eigen::Vector3d::UnitX();
  Eigen::Vector3d t2 = Eigen::Vector3d::UnitY();

  Eigen::Vector3d AxisOf(double a, double b) const { return u0 + a * t1 + b * t2; }

  bool operator()(const double* x, double* residuals, double* jacobian) const {
    const Eigen::Vector3d axis = AxisOf(x[3], x[4]);
    AnalyticResidual result;
    EvaluateAnalytic(model, *scan, {x[0], x[1], x[2]}, axis, result);
    Eigen::Map<Eigen::Matrix<double, kPeerReadings, 1>>{residuals} = result.r;
    if (jacobian == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, kPeerReadings, tracker::kParameters>> J(jacobian);
    const double inverse_length = 1 / axis.norm();
    J.leftCols<3>() = result.J.leftCols<3>();
    J.col(3) = inverse_length * (result.e1.dot(t1) * result.J.col(3) + result.e2.dot(t1) * result.J.col(4));
    J.col(4) = inverse_length * (result.e1.dot(t2) * result.J.col(3) + result.e2.dot(t2) * result.J.col(4));
    return true;
  }
};

class CeresTiny final : public Peer {
 public:
  CeresTiny(const tracker::Model& model, const PeerOptions& options) : model_(model), cost_{model_} {
    solver_.options.function_tolerance = kTypicalCost * options.function_tolerance;
    solver_.options.max_num_iterations = options.iterations_max;
  }

  PeerFit Solve(const PeerScan& scan, const PeerPose& start) override {
    cost_.scan = &scan;
    cost_.u0 = base::ToEigen(start.axis_base);
    const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(cost_.u0);
    cost_.t1 = basis.e1;
    cost_.t2 = basis.e2;
    const base::Vec3& p = start.position_base_m;
    Eigen::Matrix<double, tracker::kParameters, 1> x;
    x << p.x, p.y, p.z, 0, 0;
    const auto& summary = solver_.Solve(cost_, &x);
    return {.pose = {{x[0], x[1], x[2]}, base::FromEigen(cost_.AxisOf(x[3], x[4]).normalized())},
            .chi2 = 2 * summary.final_cost,
            .iterations = summary.iterations,
            .converged = summary.status != Solver::HIT_MAX_ITERATIONS};
  }

 private:
  using Solver = ceres::TinySolver<TinyCost>;
  tracker::Model model_;
  TinyCost cost_;
  Solver solver_;
};

}  // namespace

std::unique_ptr<Peer> MakeCeresTiny(const tracker::Model& model, const PeerOptions& options) {
  return std::make_unique<CeresTiny>(model, options);
}

}  // namespace omni::peers
