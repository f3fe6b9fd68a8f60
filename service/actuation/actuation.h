// Actuation: turns a force on the tool into coil currents; limits take precedence.
// Paper Eq. 6-8 with the errata of docs/theory/actuation.md: F = X(pose) I, X from the coils' fields at the magnet.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/actuation/force_map.h"
#include "service/actuation/heat.h"
#include "service/base/device_geometry.h"
#include "service/base/force_limit.h"
#include "service/base/tool_state.h"

namespace omni::actuation {

struct Config {
  ForceMap map;  // prepared by MakeConfig
  HeatConfig heat;
  double current_max_A = 15;
  double current_slew_A_s = 6000;
  double force_max_N = 2;
  double power_max_W = 300;         // of all coils together
  double gap_max_m = 0.12;          // beyond: no force is available
  double gap_fade_m = 0.02;         // force_max fades to zero over this before gap_max
  double singular_ratio = 0.2;      // sigma_min / sigma_max of X below which the weak direction is damped
  bool compensate_snapping = true;  // add the current that cancels the core's pull while rendering
  double bias_fade_N = 0.5;         // the compensation grows from 0 to all of it over this request
};

struct State {
  std::array<double, 3> last_current_A{};
  double last_force_N = 0;  // produced by those currents at the tool's pose
  HeatState heat;
};
static_assert(std::is_trivially_copyable_v<State>);

// Nominal, or with magnet and core as calibrated.
Config MakeConfig(const base::DeviceGeometry& device);
Config MakeConfig(const base::DeviceGeometry& device, const base::Calibration& calibration);

// Updates the coils' temperatures: once per scan, before ComputeDeratedLimit.
void UpdateHeat(const Config& config, const base::HallScan& scan, State& state) noexcept;

// What the coils can do at this pose with `current_max_A` each. Not tracking, too far or inside the windings: valid =
// false. Near the singular pose (pen perpendicular to the radius) the direction that the coils cannot push fades out of
// ampere_per_newton, continuously, and near_singular says so. docs/theory/actuation.md (3.1)
base::ForceLimit ComputeDeratedLimit(const Config& config, const base::ToolState& tool, const HeatState& heat) noexcept;
// The same for coils and body that have all been at these temperatures for long.
base::ForceLimit ComputeForceLimit(const Config& config, const base::ToolState& tool,
                                   const std::array<double, 3>& coil_temperature_C) noexcept;

// F_max: the largest force in `direction` that keeps it, with coils at these temperatures.
double ForceMax_N(const Config& config, const base::ToolState& tool, const base::Vec3& direction,
                  const std::array<double, 3>& coil_temperature_C) noexcept;

// Currents for `force_N` under `limit`: a request that cannot be met is scaled, keeping its direction
// (docs/decisions/0007-infeasible-forces.md), one that can is made as it is; then slew and rise limits, and those of
// the force actually produced. Always finite and within limits; zero at once when any input is in doubt. Slew and rise
// limits apply to growth: falling is free. Returns the force that is made: Rendered_N of the request, and less while a
// limit holds the currents back.
base::Vec3 Allocate(const Config& config, const base::ForceLimit& limit, const base::Vec3& force_N, double dt_s,
                    State& state, base::CoilCurrents& currents) noexcept;

// The force on the tool that `coil_current_A` produces at its pose, core's pull included. Zero outside the map.
base::Vec3 ForceFromCurrents(const ForceMap& map, const base::ToolState& tool,
                             const std::array<double, base::kCoilCount>& coil_current_A) noexcept;

}  // namespace omni::actuation
