// Bad input for the tick: what a broken sensor, a wrong driver, a second magnet or a hostile device could send.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "service/base/hall_scan.h"
#include "service/sim/fields/random.h"

namespace omni::sim {

// Data that a fault may use. `held` is fixed during an episode.
struct FaultContext {
  Random& random;
  base::HallScan held;                                      // the last good scan before the episode
  std::array<base::Vec3, base::kSensorCount> other_magnet;  // field of a second pen nearby
  std::array<base::Vec3, base::kSensorCount> no_pen;        // field of the coils alone at this scan's currents
  std::uint32_t sensors = 0;                                // chosen for this episode, at least one bit
  double noise_T = 0;
};

struct ScanFault {
  const char* name;
  void (*apply)(FaultContext& context, base::HallScan& scan);
  // The pen has not moved, so a published pose must be right or marked as lost or absent.
  bool pen_is_there;
};

// The first is "none".
std::span<const ScanFault> ScanFaults();

}  // namespace omni::sim
