// Inputs of the passive pen: tip force, select by hysteresis, thumbstick; edges counted.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/input_state.h"
#include "service/haptics/haptics.h"

namespace omni::loop {

struct InputConfig {
  double tip_force_full_N = 1.0;   // tip force 1.0
  double select_press_N = 0.15;    // select goes down here ...
  double select_release_N = 0.08;  // ... and up here
  double force_filter_s = 0.010;   // time constant on the tip force: tracking noise times stiffness must not click
  double value_resolution = 1.0 / 1024;  // smaller changes of analogue values are not changes
};

struct InputTracker {
  base::InputState inputs;
  double tip_force_N = 0;  // filtered
  std::int64_t t_ns = 0;   // of the last update
};
static_assert(std::is_trivially_copyable_v<InputTracker>);

// t_ns: the Hall sample's time. `live` false (not tracked or gate closed): everything goes to rest.
void UpdateInputs(const InputConfig& config, const haptics::Output& haptics, bool live, std::int64_t t_ns,
                  InputTracker& tracker) noexcept;

}  // namespace omni::loop
