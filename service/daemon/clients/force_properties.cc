#include "service/daemon/clients/force_clients.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "service/base/limits.h"

namespace omni::daemon {
namespace {

constexpr double kReachStep_m = 0.001;  // how near to the end of the reach the last row lies

// The 26 directions to a cube's corners, edges and faces.
std::vector<base::Vec3> Directions() {
  std::vector<base::Vec3> all;
  for (const double z : {-1, 0, 1}) {
    for (const double y : {-1, 0, 1}) {
      for (const double x : {-1, 0, 1}) {
        const base::Vec3 d{x, y, z};
        if (d != base::Vec3{}) all.push_back(d);
      }
    }
  }
  return all;
}

// Above the centre of the base, pointing at it.
base::ToolState PointingDown(const base::DeviceGeometry& device, double tip_offset_m, double device_point_m) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.ever_tracked = true;
  tool.axis_base = {0, 0, -1};
  tool.position_base_m = {0, 0, device_point_m + tip_offset_m};
  tool.device_point_base_m = {0, 0, device_point_m};
  tool.gap_m = tool.position_base_m.z - device.magnet.half_height_m - device.hull_radius_m;
  return tool;
}

std::array<double, base::kCoilCount> Cold(const actuation::Config& config) {
  std::array<double, base::kCoilCount> temperature_C{};
  temperature_C.fill(config.heat.nodes.air_C);
  return temperature_C;
}

double WeakestForce_N(const actuation::Config& config, const base::ToolState& tool) {
  const base::ForceLimit limit = actuation::ComputeForceLimit(config, tool, Cold(config));
  double weakest_N = limit.valid ? limit.force_max_N : 0;
  for (const base::Vec3& d : Directions()) weakest_N = std::min(weakest_N, base::ForceMax_N(limit, d));
  return weakest_N;
}

// Warmest copper above the air when these currents flow for ever: all heat goes through the body, each coil's own
// through its contact with it. docs/theory/thermal.md (1), (2) at rest
double Excess_C(const actuation::HeatConfig& heat, const base::Vec3& force_N, const base::ForceLimit& limit) {
  double sum_W = 0;
  double most_W = 0;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const double* row = &limit.ampere_per_newton[3 * k];
    const double current_A = row[0] * force_N.x + row[1] * force_N.y + row[2] * force_N.z + limit.bias_A[k];
    const double hot_ohm =
        heat.resistance_20C_ohm[k] * (1 + actuation::kCopperPerKelvin * (heat.temperature_aim_C - 20));
    const double power_W = current_A * current_A * hot_ohm;
    sum_W += power_W;
    most_W = std::max(most_W, power_W);
  }
  return sum_W / heat.nodes.body_to_air_W_K + most_W / heat.nodes.copper_to_body_W_K;
}

// In the direction in which it is least.
double ContinuousForce_N(const actuation::Config& config, const base::ToolState& tool) {
  const base::ForceLimit limit = actuation::ComputeForceLimit(config, tool, Cold(config));
  const double allowed_C = config.heat.temperature_aim_C - config.heat.nodes.air_C;
  double least_N = WeakestForce_N(config, tool);
  for (const base::Vec3& d : Directions()) {
    const double norm = Norm(d);
    double low_N = 0;
    double high_N = least_N;
    for (int i = 0; i < 30; ++i) {
      const double middle_N = 0.5 * (low_N + high_N);
      const double scale = middle_N / norm;
      const bool cool = Excess_C(config.heat, {scale * d.x, scale * d.y, scale * d.z}, limit) <= allowed_C;
      (cool ? low_N : high_N) = middle_N;
    }
    least_N = low_N;
  }
  return least_N;
}

}  // namespace

protocol::ForceProperties DescribeForce(const loop::TickConfig& config, const base::DeviceGeometry& device) {
  protocol::ForceProperties properties;
  properties.available = 1;
  properties.max_force_N = config.actuation.force_max_N;
  properties.max_stiffness_N_m = config.haptics.stiffness_max_N_m;
  properties.max_damping_Ns_m = config.haptics.hand_damping_Ns_m;
  properties.update_rate_Hz = 1 / base::kTickPeriod_s;
  const double tip_offset_m = config.tracker.model.tip_offset_m;
  const double beyond_magnet_m = tip_offset_m - device.magnet.half_height_m;
  properties.inner_radius_m = device.hull_radius_m + std::max(0.0, -beyond_magnet_m);
  properties.outer_radius_m = device.hull_radius_m + config.actuation.gap_max_m - beyond_magnet_m;
  properties.continuous_force_N =
      ContinuousForce_N(config.actuation, PointingDown(device, tip_offset_m, properties.inner_radius_m + kReachStep_m));
  const double last_m = properties.outer_radius_m - kReachStep_m;
  for (std::uint32_t i = 0; i < protocol::kMaxForceReach; ++i) {
    const double share = static_cast<double>(i) / (protocol::kMaxForceReach - 1);
    const double distance_m = properties.inner_radius_m + share * (last_m - properties.inner_radius_m);
    properties.reach[i] = {distance_m,
                           WeakestForce_N(config.actuation, PointingDown(device, tip_offset_m, distance_m))};
  }
  properties.reach_count = protocol::kMaxForceReach;
  return properties;
}

}  // namespace omni::daemon
