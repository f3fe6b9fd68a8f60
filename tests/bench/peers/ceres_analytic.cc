#include <ceres/sized_cost_function.h>

#include "tests/bench/peers/analytic.h"
#include "tests/bench/peers/ceres_pose.h"

namespace omni::peers {
namespace {

using RowMajor3 = Eigen::Matrix<double, kPeerReadings, 3, Eigen::RowMajor>;

class AnalyticCost final : public ceres::SizedCostFunction<kPeerReadings, 3, 3> {
 public:
  AnalyticCost(const tracker::Model& model, const PeerScan& scan) : model_(model), scan_(scan) {}

  // Ceres needs the derivative by the three numbers of the axis and projects it on the sphere itself: J_u = j_1 e1^T +
  // j_2 e2^T agrees with the truth along every tangent.
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    AnalyticResidual result;
    EvaluateAnalytic(model_, scan_, Eigen::Map<const Eigen::Vector3d>(parameters[0]),
                     Eigen::Map<const Eigen::Vector3d>(parameters[1]), result);
    Eigen::Map<Eigen::Matrix<double, kPeerReadings, 1>>{residuals} = result.r;
    if (jacobians == nullptr) return true;
    if (jacobians[0] != nullptr) Eigen::Map<RowMajor3>{jacobians[0]} = result.J.leftCols<3>();
    if (jacobians[1] != nullptr) {
      Eigen::Map<RowMajor3>{jacobians[1]} =
          result.J.col(3) * result.e1.transpose() + result.J.col(4) * result.e2.transpose();
    }
    return true;
  }

 private:
  const tracker::Model& model_;
  const PeerScan& scan_;
};

class CeresAnalytic final : public Peer {
 public:
  CeresAnalytic(const tracker::Model& model, PeerLinearSolver linear, const PeerOptions& options)
      : model_(model), pose_(std::make_unique<AnalyticCost>(model_, scan_), linear, options) {}

  PeerFit Solve(const PeerScan& scan, const PeerPose& start) override {
    scan_ = scan;
    return pose_.Solve(start);
  }

 private:
  tracker::Model model_;
  PeerScan scan_;
  CeresPose pose_;
};

}  // namespace

std::unique_ptr<Peer> MakeCeresAnalytic(const tracker::Model& model, PeerLinearSolver linear,
                                        const PeerOptions& options) {
  return std::make_unique<CeresAnalytic>(model, linear, options);
}

}  // namespace omni::peers
