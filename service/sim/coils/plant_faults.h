// What can be broken in a simulated base, all of it while it runs.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "service/base/limits.h"
#include "service/sim/fields/truth_model.h"

namespace omni::sim {

enum class HallFault : std::uint8_t {
  kNone,
  kStuck,          // the same sample again and again, each marked as fresh
  kStopped,        // answers, but its conversions have ended
  kDead,           // does not answer
  kWrongIdentity,  // another device answers
};

struct PlantFaults {
  std::array<HallFault, base::kSensorCount> hall{};
  std::array<bool, base::kCoilCount> current_sensor_dead{};
  std::array<bool, base::kCoilCount> coil_open{};
  std::array<bool, base::kCoilCount> coil_shorted{};  // most of its turns
  std::array<bool, base::kCoilCount> bridge{};        // reports a fault and no longer drives
  std::optional<double> supply_V;                     // of the source
  bool fan_stands = false;
  bool emergency_stop = false;  // the switch is open
  CoilArray extra_heat_W{};     // into the copper, from outside
};

}  // namespace omni::sim
