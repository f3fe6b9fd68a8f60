// Finds the tool without a hint. docs/theory/tracking.md (6.2), (6.3)
#pragma once

#include "service/tracker/solve/solver.h"

namespace omni::tracker {

inline constexpr int kColdCandidates = 6;      // in the tick
inline constexpr int kColdCandidatesMax = 24;  // off it

struct ColdCandidates {
  int count = 0;
  std::array<Pose, kColdCandidatesMax> poses;
};

// The best `wanted` places of the model's grid, best first, each with the direction that fits best there.
template <int kCapacity>
ColdCandidates RankGrid(const Model& model, const BasicMeasurement<kCapacity>& measurement,
                        int wanted = kColdCandidates) noexcept;
extern template ColdCandidates RankGrid(const Model&, const Measurement&, int) noexcept;
extern template ColdCandidates RankGrid(const Model&, const ArrayMeasurement&, int) noexcept;

}  // namespace omni::tracker
