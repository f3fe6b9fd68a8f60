// How hot the copper is, and how much current it may carry so that it never gets hotter than allowed.
// A two-node model run from the measured currents; the device's own temperatures can only raise it. The copper's peak
// is hidden from anything that measures the body. docs/theory/thermal.md
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/limits.h"

namespace omni::actuation {

inline constexpr double kCopperPerKelvin = 0.00393;  // resistance of copper per kelvin, from 20 C

struct HeatConfig {
  base::HeatGeometry nodes;
  std::array<double, base::kCoilCount> resistance_20C_ohm{};
  double current_max_A = 15;
  double supply_V = 12;
  double temperature_aim_C = 67.5;  // where full load settles
  double temperature_max_C = 70;    // no current here
  double decay = 0.756;             // of the copper's excess over the body within 5 s; prepared by MakeHeatConfig
  double follow_s = 0.2;            // a warmer reading of the device is followed with this lag
  double fall_A_s = 300;            // ceilings move no faster: no step in what the hand feels
  double rise_A_s = 15;
};
HeatConfig MakeHeatConfig(const base::DeviceGeometry& device);

struct HeatState {
  bool started = false;
  std::int64_t t_ns = 0;  // of the last scan
  std::array<double, base::kCoilCount> copper_C{};
  double body_C = 0;
  std::array<double, base::kCoilCount> current_max_A{};  // what every coil may carry now
};
static_assert(std::is_trivially_copyable_v<HeatState>);

// Once per scan. `commanded_A`: used where the measured current is smaller or missing.
void UpdateHeat(const HeatConfig& config, const base::HallScan& scan,
                const std::array<double, base::kCoilCount>& commanded_A, HeatState& state) noexcept;

// Only the nodes, by dt_s, from the currents that flow: the model itself.
void AdvanceHeat(const HeatConfig& config, const std::array<double, base::kCoilCount>& current_A, double dt_s,
                 HeatState& state) noexcept;

// R_k(T): docs/theory/thermal.md (3). That of the hottest copper for a temperature that no copper of a base has.
double CopperResistance_ohm(const HeatConfig& config, std::size_t k, double copper_C) noexcept;

// The current that coil k may carry at these temperatures for good use of the time left: with it the copper approaches
// the aim and never passes it, however warm the body is. Zero in doubt. docs/theory/thermal.md (5)
double CurrentCeiling_A(const HeatConfig& config, std::size_t k, double copper_C, double body_C) noexcept;

}  // namespace omni::actuation
