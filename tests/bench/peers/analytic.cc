#include "tests/bench/peers/analytic.h"

#include "service/tracker/solve/solver.h"
#include "tests/bench/peers/whitening.h"

namespace omni::peers {

void EvaluateAnalytic(const tracker::Model& model, const PeerScan& scan, const Eigen::Vector3d& position,
                      const Eigen::Vector3d& axis, AnalyticResidual& result) {
  const tracker::PosePoint point = tracker::MakePosePoint({position, axis.normalized()});
  tracker::ModelField field;
  tracker::EvaluateField(model, point, field);
  for (std::size_t row = 0; row < kPeerReadings; ++row) {
    const auto i = static_cast<Eigen::Index>(row);
    const double w = scan.inverse_sigma[row];
    result.r[i] = w * field.field_sensor_T[row] - scan.whitened[row];
    for (std::size_t k = 0; k < tracker::kParameters; ++k) {
      result.J(i, static_cast<Eigen::Index>(k)) = w * field.jacobian[row][k];
    }
  }
  RemoveNuisance(scan, result.r.data(), 1);
  for (Eigen::Index k = 0; k < tracker::kParameters; ++k) {
    RemoveNuisance(scan, result.J.data() + k, tracker::kParameters);
  }
  result.e1 = Eigen::Map<const Eigen::Vector3d>(point.tangent_1_base.data());
  result.e2 = Eigen::Map<const Eigen::Vector3d>(point.tangent_2_base.data());
}

}  // namespace omni::peers
