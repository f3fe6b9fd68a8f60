// A cable that damages frames: each fault with its own probability, drawn from a seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "service/sim/fields/random.h"

namespace omni::hil {

using Frame = std::vector<std::uint8_t>;

// Probabilities in [0, 1]; at most one fault per frame, tried in this order.
struct LinkFaults {
  double drop = 0;
  double corrupt = 0;    // one bit
  double truncate = 0;   // to a random length, at least one byte
  double duplicate = 0;  // the same frame twice
  double reorder = 0;    // after the next one
};

struct LinkCounts {
  std::uint64_t frames = 0;
  std::uint64_t dropped = 0;
  std::uint64_t corrupted = 0;
  std::uint64_t truncated = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t reordered = 0;
  std::uint64_t damaged() const { return corrupted + truncated; }
};

class FaultyLink {
 public:
  explicit FaultyLink(std::uint64_t seed) : random_(seed) {}

  void SetFaults(const LinkFaults& faults) { faults_ = faults; }

  // Passes `frame` through the cable and outputs none, one or two frames.
  void Pass(Frame frame, const std::function<void(Frame)>& out);

  const LinkCounts& counts() const { return counts_; }

 private:
  bool Happens(double probability) { return probability > 0 && random_.Uniform() < probability; }

  sim::Random random_;
  LinkFaults faults_;
  LinkCounts counts_;
  Frame held_;  // waits for the next one
};

}  // namespace omni::hil
