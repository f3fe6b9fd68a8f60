// The tracker's own residual and Jacobian in the form that Ceres needs.
#pragma once

#include <Eigen/Core>

#include "service/tracker/kernel/model.h"
#include "tests/bench/peers/peer.h"

namespace omni::peers {

struct AnalyticResidual {
  Eigen::Matrix<double, kPeerReadings, 1> r;
  Eigen::Matrix<double, kPeerReadings, tracker::kParameters, Eigen::RowMajor> J;  // position, turn along e1, e2
  Eigen::Vector3d e1, e2;
};

// `axis` need not be a unit vector: its direction counts, and the Jacobian is that at the unit vector.
void EvaluateAnalytic(const tracker::Model& model, const PeerScan& scan, const Eigen::Vector3d& position,
                      const Eigen::Vector3d& axis, AnalyticResidual& result);

}  // namespace omni::peers
