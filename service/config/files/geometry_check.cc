#include "service/config/files/geometry_check.h"

#include <cmath>
#include <cstdio>

namespace omni::config {
namespace {

using base::Vec3;

constexpr double kAxesVolumeMin = 0.5;  // |det| of the three coil axes; 1: perpendicular, 0: in one plane

double Volume(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.x * (b.y * c.z - b.z * c.y) - a.y * (b.x * c.z - b.z * c.x) + a.z * (b.x * c.y - b.y * c.x);
}

// "<left> = 0.01 must be < <right> = 0.015", if it is not so.
std::string NotLess(const std::string& left, double left_value, const std::string& right, double right_value,
                    bool or_equal) {
  if (or_equal ? left_value <= right_value : left_value < right_value) return {};
  char values[2][32];
  std::snprintf(values[0], sizeof(values[0]), "%.9g", left_value);
  std::snprintf(values[1], sizeof(values[1]), "%.9g", right_value);
  return left + " = " + values[0] + " must be " + (or_equal ? "<= " : "< ") + right + " = " + values[1] +
         "; correct one of the two";
}

std::string CoilProblem(const base::DeviceGeometry& device, std::size_t i) {
  const base::CoilGeometry& coil = device.coils[i];
  const std::string name = "coils[" + std::to_string(i) + "].";
  std::string problem =
      NotLess("core.core_radius_m", device.core_radius_m, name + "shell_radius_min_m", coil.shell_radius_min_m, true);
  if (problem.empty()) {
    problem = NotLess(name + "shell_radius_min_m", coil.shell_radius_min_m, name + "shell_radius_max_m",
                      coil.shell_radius_max_m, false);
  }
  if (problem.empty()) {
    problem =
        NotLess(name + "shell_radius_max_m", coil.shell_radius_max_m, "hull.hull_radius_m", device.hull_radius_m, true);
  }
  // Turns lie at distances up to the half width from the middle plane: on every shell they need room.
  if (problem.empty()) {
    problem = NotLess(name + "band_half_width_m", coil.band_half_width_m, name + "shell_radius_min_m",
                      coil.shell_radius_min_m, false);
  }
  return problem;
}

std::string SensorProblem(const base::DeviceGeometry& device, std::size_t i) {
  const Vec3& p = device.sensors[i].position_base_m;
  const std::string name = "|sensors[" + std::to_string(i) + "].position_base_m|";
  std::string problem = NotLess("core.core_radius_m", device.core_radius_m, name, Norm(p), false);
  for (std::size_t k = 0; problem.empty() && k < i; ++k) {
    if (device.sensors[k].position_base_m == p) {
      problem = "sensors[" + std::to_string(k) + "] and sensors[" + std::to_string(i) +
                "] are at the same place; correct position_base_m";
    }
  }
  return problem;
}

}  // namespace

std::string GeometryProblem(const base::DeviceGeometry& device) {
  std::string problem =
      NotLess("core.core_radius_m", device.core_radius_m, "hull.hull_radius_m", device.hull_radius_m, false);
  if (problem.empty()) {
    problem =
        NotLess("sensor.sensor_lsb_T", device.sensor_lsb_T, "sensor.sensor_range_T", device.sensor_range_T, false);
  }
  if (problem.empty()) {
    problem = NotLess("limits.temperature_derate_C", device.temperature_derate_C, "limits.temperature_max_C",
                      device.temperature_max_C, false);
  }
  for (std::size_t i = 0; problem.empty() && i < device.coils.size(); ++i) problem = CoilProblem(device, i);
  for (std::size_t i = 0; problem.empty() && i < device.sensors.size(); ++i) problem = SensorProblem(device, i);
  const double volume =
      std::abs(Volume(device.coils[0].axis_base, device.coils[1].axis_base, device.coils[2].axis_base));
  if (problem.empty() && !(volume >= kAxesVolumeMin)) {
    problem = "the three coils' axis_base span a volume of " + std::to_string(volume) +
              " (perpendicular: 1), must be at least 0.5; correct the axes";
  }
  return problem;
}

}  // namespace omni::config
