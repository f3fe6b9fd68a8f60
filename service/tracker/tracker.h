// The tracker: one Hall scan in, the tool's 5-DoF pose out. Fixed-size Levenberg-Marquardt on position and direction.
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/tool_state.h"
#include "service/tracker/model.h"

namespace omni::tracker {

struct Config {
  Model model;                    // prepared by MakeConfig: sensors, coil maps, magnet, core
  double chi2_max = 80;           // gate at 19 degrees of freedom: larger = this scan does not fit
  double field_min_T = 4e-7;      // rms of the magnet's field over sensors below this: absent
  int iterations_max = 8;
  double reach_min_m = 0.030;     // |position| outside [min, max] or below z_min_m: not a pose
  double reach_max_m = 0.250;
  double z_min_m = -0.030;
  double acceleration_noise_m2_s3 = 1.0;  // constant-velocity filter
  int lost_after_scans = 20;      // bad scans in a row before kAbsent and a cold start
};

struct State {
  bool initialised = false;
  int bad_scans = 0;
  std::int64_t t_ns = 0;
  bool ever_tracked = false;
  base::Vec3 position_base_m, axis_base{0, 0, -1}, velocity_base_m_s, angular_velocity_base_rad_s;
  std::array<double, 9> filter_covariance{};   // the filter's own
  base::ToolState last_good;
};
static_assert(std::is_trivially_copyable_v<State>);

Config MakeConfig(const base::DeviceGeometry& device);

// Warm start from `state` (predicted to the scan's time) or cold start without a hint. Never throws, allocates or returns
// a non-finite pose: a scan that does not fit gives kLost (the last good pose) and, after lost_after_scans, kAbsent.
void Update(const Config& config, const base::HallScan& scan, State& state, base::ToolState& tool) noexcept;

// Constant-velocity prediction of `tool` to t_ns, at most 20 ms ahead.
base::ToolState Predict(const base::ToolState& tool, std::int64_t t_ns, double tip_offset_m) noexcept;

}  // namespace omni::tracker
