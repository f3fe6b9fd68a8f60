// Finds the pen without a hint. docs/theory/tracking.md (8), (9)
#pragma once

#include "service/tracker/solver.h"

namespace omni::tracker {

inline constexpr int kColdCandidates = 6;

struct ColdCandidates {
  int count = 0;
  std::array<Pose, kColdCandidates> poses;
};

// The best grid points, best first, each with the direction that fits best there.
ColdCandidates RankGrid(const Model& model, const Measurement& measurement) noexcept;

}  // namespace omni::tracker
