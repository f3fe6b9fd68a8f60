// Common part of the two Ceres peers: one problem of a position and an axis on the sphere, built once.
#pragma once

#include <array>
#include <memory>

#include "tests/bench/peers/peer.h"

namespace ceres {
class CostFunction;
}

namespace omni::peers {

// Solves a cost function of (position[3], axis[3]) whose scan the caller swaps beneath it.
class CeresPose {
 public:
  CeresPose(std::unique_ptr<ceres::CostFunction> cost, PeerLinearSolver linear, const PeerOptions& options);
  ~CeresPose();
  PeerFit Solve(const PeerPose& start);

 private:
  struct Parts;  // keeps Ceres out of this header
  std::unique_ptr<Parts> parts_;
};

}  // namespace omni::peers
