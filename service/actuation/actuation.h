// Actuation: a force on the tool into coil currents, limits with the last word.
// Paper Eq. 6-8 with the errata of docs/theory/actuation.md: F = X(pose) I, X from the coils' fields at the magnet.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/actuation_types.h"
#include "service/base/device_geometry.h"
#include "service/base/force_limit.h"
#include "service/base/tool_state.h"
#include "service/actuation/force_map.h"

namespace omni::actuation {

struct Config {
  ForceMap map;                      // prepared by MakeConfig
  double current_max_A = 15;
  double current_slew_A_s = 6000;
  double force_max_N = 2;
  double temperature_derate_C = 60;  // linear derating from here ...
  double temperature_max_C = 70;     // ... to zero here
  std::array<double, 3> resistance_20C_ohm{};
  double supply_V = 12;
  double power_max_W = 300;          // total
  double gap_max_m = 0.12;           // farther: no force is offered
  bool compensate_snapping = true;   // add the current that cancels the core's pull while rendering
};

struct State {
  std::array<double, 3> last_current_A{};
};
static_assert(std::is_trivially_copyable_v<State>);

Config MakeConfig(const base::DeviceGeometry& device);

// What the coils can do at this pose and these temperatures. Not tracking, too far or singular: valid = false.
base::ForceLimit ComputeForceLimit(const Config& config, const base::ToolState& tool,
                                   const std::array<double, 3>& coil_temperature_C) noexcept;

// Currents for `force_N` under `limit`: scaled as a vector when infeasible, then slew, temperature and power limits.
// Always finite and within limits; zero (slewed) when anything is in doubt.
void Allocate(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N, double dt_s, State& state,
              base::CoilCurrents& currents) noexcept;

}  // namespace omni::actuation
